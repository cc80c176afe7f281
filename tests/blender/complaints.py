# SPDX-License-Identifier: GPL-3.0-or-later
"""Listen for tracebacks between two steps of one test."""

from __future__ import annotations

import os
import stat
import sys


class Complaints:
    """What Blender and Python say on the way. Python's last resort for callbacks is ``sys.excepthook``."""

    WORDS = (b"Traceback", b"Error in bpy.app.handlers", b"Dependency cycle")

    def __init__(self) -> None:
        self.raised: list[BaseException] = []
        self._before = sys.excepthook
        sys.excepthook = lambda kind, error, trace: self.raised.append(error.with_traceback(trace))
        self._read = {fd: self._size(fd) for fd in (1, 2)}

    def close(self) -> None:
        sys.excepthook = self._before

    @staticmethod
    def _size(fd: int) -> int:
        """Bytes said so far, where a file takes them."""
        found = os.fstat(fd)
        return found.st_size if stat.S_ISREG(found.st_mode) else 0

    def check(self) -> None:
        """Nothing was raised and nothing bad was said since the last call."""
        if self.raised:
            raise self.raised.pop()
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        for fd, start in self._read.items():
            size = self._size(fd)
            said = os.pread(fd, max(0, size - start), start) if size > start else b""
            self._read[fd] = size
            assert not any(word in said for word in self.WORDS), said.decode(errors="replace")
