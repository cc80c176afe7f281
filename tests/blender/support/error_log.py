# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds tracebacks and errors that appear between two steps of one test."""

from __future__ import annotations

import os
import stat
import sys


class ErrorLog:
    """The exceptions and error messages since the last check.

    Exceptions of callbacks reach ``sys.excepthook``.
    """

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
        """The size of the output so far, if it goes to a file."""
        found = os.fstat(fd)
        return found.st_size if stat.S_ISREG(found.st_mode) else 0

    @staticmethod
    def _between(fd: int, start: int, end: int) -> bytes:
        """A part of the output; writing goes on at the end. Windows has no ``pread``."""
        os.lseek(fd, start, os.SEEK_SET)
        try:
            return os.read(fd, end - start)
        finally:
            os.lseek(fd, 0, os.SEEK_END)

    def check(self) -> None:
        """Fail if an exception was raised or an error was printed since the last call."""
        if self.raised:
            raise self.raised.pop()
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        for fd, start in self._read.items():
            size = self._size(fd)
            printed = self._between(fd, start, size) if size > start else b""
            self._read[fd] = size
            assert not any(word in printed for word in self.WORDS), printed.decode(errors="replace")
