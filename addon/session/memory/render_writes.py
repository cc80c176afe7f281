# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes of a render thread, carried out by the main thread where its window draws meanwhile.

Telling Blender of a changed shape marks every dependency graph, the window's too. Where the interface is
not locked, the window may be evaluating its own at that moment, and Blender crashes. So the render thread
hands the write over and waits until the main thread has done it, between two evaluations.
"""

import queue
import threading
from collections.abc import Callable

import bpy
from bpy.types import Scene

PATIENCE = 2.0  # seconds; a main thread that waits for the render to stop serves nobody, and draws nothing


class _Write:
    """A write that one of two threads carries out, once."""

    def __init__(self, write: Callable[[], bool]) -> None:
        self._write = write
        self._claim = threading.Lock()
        self.done = threading.Event()
        self.result: bool | None = None  # None: it was not carried out

    def run(self) -> None:
        """Carry it out, unless the other thread did, or does so now."""
        if not self._claim.acquire(blocking=False):
            return
        try:
            self.result = self._write()
        except AttributeError:  # for a moment at its start a render forbids all writes but its own
            self.result = None
        finally:
            self.done.set()


_writes: queue.SimpleQueue[_Write] = queue.SimpleQueue()


def must_hand_over(scene: Scene) -> bool:
    """A window may draw while this scene renders."""
    return not bpy.app.background and not scene.render.use_lock_interface


def write(scene: Scene, call: Callable[[], bool], lock: threading.RLock) -> bool:
    """Carry out a write of any thread where nothing evaluates meanwhile; its result.

    ``lock`` is held by the caller, and free while it waits: the main thread may want it.
    """
    if threading.current_thread() is threading.main_thread() or not must_hand_over(scene):
        return call()
    order = _Write(call)
    _writes.put(order)
    lock.release()
    try:
        if not order.done.wait(PATIENCE):
            order.run()
            order.done.wait()
    finally:
        lock.acquire()
    return call() if order.result is None else order.result


def carry_out_writes() -> None:
    """Carry out what render threads wait for. Main thread."""
    while True:
        try:
            order = _writes.get_nowait()
        except queue.Empty:
            return
        order.run()
