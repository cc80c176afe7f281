# SPDX-License-Identifier: GPL-3.0-or-later
"""Claims, waiting and parts, for the sessions: scripts that drive a Blender with a window by mouse and keys.

A session has parts. Each is a generator that begins with Blender's startup file; each ``yield`` gives Blender
the time that a person would take. ``with claim("what holds"):`` notes whether the assertions inside hold, and
``test_window.py`` makes a test of each claim. Outcomes and screenshots go to the folder named after ``--``.
"""

import json
import os
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import bpy
import numpy as np
from inside import inner
from installed import enable
from window import OUTPUT, pictures

enable()  # what the sessions import after this module needs it

seen: dict[str, object] = {"claims": {}}  # what the tests read; of each claim, what went wrong each time
pace = [0.05]  # seconds from one step to the next

_FAILURES = (AssertionError, AttributeError, LookupError, RuntimeError)  # something is missing, or refused


@contextmanager
def claim(text: str) -> Iterator[None]:
    """Note whether the assertions inside hold. The session goes on, whether they do or not."""
    outcomes = seen["claims"].setdefault(text, [])
    print(time.strftime("%X"), text, flush=True)  # the last one that is printed is the one that ends Blender
    try:
        yield
    except _FAILURES as error:
        told = traceback.TracebackException.from_exception(error, capture_locals=True)
        outcomes.append("".join(told.format()))
    else:
        outcomes.append("")


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """The largest difference of two shapes."""
    return float(np.abs(one - other).max())


def near(one: np.ndarray, other: np.ndarray, limit: float) -> None:
    """Assert that two shapes differ by less; the other one may be the same vector for all points."""
    assert other.shape in (one.shape, one.shape[1:])
    off = apart(one, other)
    assert off < limit, off


def above(value: float, limit: float) -> None:
    """Assert it, and tell the value."""
    assert value > limit, value


def rest(steps: int = 2) -> Iterator[None]:
    for _ in range(steps):
        yield


def until(condition: Callable[[], bool], seconds: float = 60.0) -> Iterator[None]:
    """Wait, as a person would, until ``condition()``."""
    begin = time.monotonic()
    while not condition() and time.monotonic() - begin < seconds:
        yield


def settled() -> Iterator[None]:
    """Wait until every shape is final."""
    yield from rest()
    yield from until(lambda: not inner.sessions.unsettled() and not inner.binding.busy(), 120.0)
    yield from rest()


def works() -> bool:
    """Whether a thread of Sinew is at work, or what it did is not taken in yet."""
    return any(thread.name == "sinew" for thread in threading.enumerate()) or inner.binding.busy()


def run(*parts: Callable[[], Iterator[None]]) -> None:
    """Take the steps of the parts, one part after the other, then end Blender, whatever happened."""

    def steps() -> Iterator[None]:
        try:
            for part in parts:
                enable()
                bpy.ops.wm.read_homefile(use_factory_startup=True)
                pictures[0] = OUTPUT / part.__name__
                pictures[0].mkdir(parents=True, exist_ok=True)
                print(time.strftime("%X"), part.__name__, flush=True)
                yield from rest()
                try:
                    yield from part()
                except _FAILURES:  # the next part may be right
                    seen["error"] = seen.get("error", "") + traceback.format_exc()
        finally:  # the test reads the reason
            if sys.exc_info()[0] is not None:
                seen["error"] = seen.get("error", "") + traceback.format_exc()
            (OUTPUT / "seen.json").write_text(json.dumps(seen, indent=1), encoding="utf-8")
            sys.stdout.flush()
            os._exit(0)

    journey = steps()

    def tick() -> float:
        next(journey)
        return pace[0]

    preferences = bpy.context.preferences
    preferences.view.show_splash = preferences.view.show_tooltips = False
    # Without a GPU, smooth edges take half of the time; by default each picture is drawn eight times.
    smooth = "SINEW_SMOOTH_PICTURES" in os.environ
    preferences.system.viewport_aa = "FXAA" if smooth else "OFF"
    preferences.system.use_overlay_smooth_wire = preferences.system.use_edit_mode_smooth_wire = smooth
    bpy.app.timers.register(tick, first_interval=1.5, persistent=True)
