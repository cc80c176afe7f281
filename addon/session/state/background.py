# SPDX-License-Identifier: GPL-3.0-or-later
"""A native call in a thread of its own, so that Blender's window still responds. It uses no Blender data."""

import atexit
import sys
import threading
import time
import weakref
from collections.abc import Callable
from typing import Any

from ...backend import Progress
from ...core.errors import SinewError, UnforeseenError

_UNFORESEEN = "A mistake in Sinew ended this work - please report it with what the console shows"
_PATIENCE = 10.0  # seconds in which a call that is cancelled has to end when Blender quits


class Work:
    """Starts ``call(progress)`` at once. When it is ``done``, either ``result`` or ``error`` is set.

    ``subject`` is what the call works on. Whoever takes the result compares it with what is wanted by then.
    """

    def __init__(self, call: Callable[[Progress], object], subject: Any = None) -> None:
        self.subject = subject
        self.fraction = 0.0
        self.stage = ""
        self.result: Any = None
        self.error: SinewError | None = None
        self.seconds = 0.0
        self._call = call
        self._cancelled = False
        self.thread = threading.Thread(target=self._run, name="sinew", daemon=True)
        _running.add(self)
        self.thread.start()

    @property
    def done(self) -> bool:
        """Whether the call has ended, with a result or an error."""
        return not self.thread.is_alive()

    def cancel(self) -> None:
        """Stop at the next progress call. This does not wait for the thread."""
        self._cancelled = True

    def _run(self) -> None:
        begin = time.perf_counter()
        try:
            self.result = self._call(self._progress)
        except SinewError as error:
            self.error = error
        finally:
            if self.result is None and self.error is None:
                # A mistake in the code: its traceback goes to the console. The error must be kept, or the
                # same call would be started again and again.
                self.error = UnforeseenError(f"{_UNFORESEEN}: {sys.exc_info()[1]!r}")
            self.seconds = time.perf_counter() - begin

    def _progress(self, fraction: float, stage: str) -> bool:
        self.fraction, self.stage = fraction, stage
        return not self._cancelled


_running: weakref.WeakSet[Work] = weakref.WeakSet()


@atexit.register
def _end() -> None:
    """Cancel what still works when Blender quits: a thread that ends within native code aborts Blender."""
    for work in list(_running):
        work.cancel()
        work.thread.join(_PATIENCE)


class Works(dict[str, Work]):
    """Works under way, each by the key of what it is for."""

    def drop(self, key: str) -> Work | None:
        """Cancel a work, if there is one, and forget it with its result."""
        dropped = self.pop(key, None)
        if dropped is not None:
            dropped.cancel()
        return dropped

    def clear(self) -> None:
        """Cancel all of them."""
        for key in list(self):
            self.drop(key)
