# SPDX-License-Identifier: GPL-3.0-or-later
"""A native call in a thread of its own, so that a window stays alive. It touches no Blender data."""

import sys
import threading
import time
from collections.abc import Callable
from typing import Any

from ...backend import Progress
from ...core.errors import SinewError, UnforeseenError

_UNFORESEEN = "A mistake in Sinew ended this work - please report it with what the console shows"


class Work:
    """Runs ``call(progress)`` at once; ask ``done``, then read ``result`` or ``error``: one of them is there.

    ``subject`` says what it is about: the one who collects it compares it with what is wanted by then.
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
        self.thread.start()

    @property
    def done(self) -> bool:
        """It ended, by result or by error."""
        return not self.thread.is_alive()

    def cancel(self) -> None:
        """Stop at the next progress call; nobody waits for it."""
        self._cancelled = True

    def _run(self) -> None:
        begin = time.perf_counter()
        try:
            self.result = self._call(self._progress)
        except SinewError as error:
            self.error = error
        finally:
            if self.result is None and self.error is None:
                # A mistake in the code: its traceback goes to the console. Whoever collects this work must
                # see that it failed, or the same work would be started again and again.
                self.error = UnforeseenError(f"{_UNFORESEEN}: {sys.exc_info()[1]!r}")
            self.seconds = time.perf_counter() - begin

    def _progress(self, fraction: float, stage: str) -> bool:
        self.fraction, self.stage = fraction, stage
        return not self._cancelled
