# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes that a render thread needs, carried out by the main thread if a window may draw at the same time.

A write to a shape mesh tags every dependency graph for an update, also the one of the window. If the
interface is not locked, the window may be evaluating its graph at that moment, and Blender crashes. So the
render thread hands the write over and waits until the main thread has carried it out between two evaluations.
"""

import queue
import threading
from collections.abc import Callable

import bpy
from bpy.types import Scene

# Seconds. If the main thread has not written by then, it is blocked because it waits for the render to stop.
# It does not draw meanwhile, so the render thread may write.
PATIENCE = 2.0


class _Write:
    """A write that either of two threads carries out, but only once."""

    def __init__(self, write: Callable[[], bool]) -> None:
        self._write = write
        self._claim = threading.Lock()
        self.done = threading.Event()
        self.result: bool | None = None  # None if it was not carried out

    def run(self) -> None:
        """Carry out the write, unless the other thread has done so or does so now."""
        if not self._claim.acquire(blocking=False):
            return
        try:
            self.result = self._write()
        except AttributeError:  # while a render starts, Blender forbids writes from other threads
            self.result = None
        finally:
            self.done.set()


_writes: queue.SimpleQueue[_Write] = queue.SimpleQueue()


def must_hand_over(scene: Scene) -> bool:
    """Whether a window may draw while this scene renders."""
    return not bpy.app.background and not scene.render.use_lock_interface


def write(scene: Scene, call: Callable[[], bool], lock: threading.RLock) -> bool:
    """Carry out a write of any thread while nothing is evaluated; returns the result of ``call``.

    The caller holds ``lock``. It is released while this waits, because the main thread may need it.
    """
    if threading.current_thread() is threading.main_thread() or not must_hand_over(scene):
        return call()
    waiting = _Write(call)
    _writes.put(waiting)
    lock.release()
    try:
        if not waiting.done.wait(PATIENCE):
            waiting.run()
            waiting.done.wait()
    finally:
        lock.acquire()
    return call() if waiting.result is None else waiting.result


def carry_out_writes() -> None:
    """Carry out the writes that render threads wait for. Main thread only."""
    while True:
        try:
            waiting = _writes.get_nowait()
        except queue.Empty:
            return
        waiting.run()
