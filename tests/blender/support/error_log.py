# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds tracebacks and errors that appear between two steps of one test."""

import os
import stat
import sys


class ErrorLog:
    """Exceptions, also of callbacks, which reach ``sys.excepthook``, and messages since the last check."""

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

    def check(self) -> None:
        """Fail if an exception was raised or an error was printed since the last call."""
        if self.raised:
            raise self.raised.pop()
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        for fd, start in self._read.items():
            size = self._read[fd] = self._size(fd)
            if size > start:
                os.lseek(fd, start, os.SEEK_SET)  # Windows has no ``pread``
                printed = os.read(fd, size - start)
                os.lseek(fd, 0, os.SEEK_END)  # where writing goes on
                assert not any(word in printed for word in self.WORDS), printed.decode(errors="replace")
