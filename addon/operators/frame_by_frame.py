# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators share that work frame by frame. With a window, they do so between redraws, with progress."""

import time
from abc import abstractmethod
from typing import ClassVar, Protocol

from bpy.props import IntProperty
from bpy.types import Context, Event

from .. import compat
from ..core.errors import SinewError
from ..properties import MAX_FRAME
from .arguments import once
from .modal.staying import StaysInWindow
from .reporting import reports_errors

_SLICE = 0.1  # seconds for which frames are computed between two redraws
_PAUSE = 0.01  # seconds to wait for a thread, if there is no timer
_SKIP = {"SKIP_SAVE"}


class Job(Protocol):
    """Work of ``total`` frames, of which ``done`` are done. Call ``step`` while it returns True, then
    ``finish``, which returns warnings. ``cancel`` leaves everything as it was; after ``finish`` it does
    nothing.
    """

    done: int

    @property
    def total(self) -> int: ...
    def step(self) -> bool: ...
    def finish(self) -> list[str]: ...
    def cancel(self) -> None: ...


class FrameByFrame(StaysInWindow):
    """Mixed into an operator, which returns its work from ``job``."""

    TICK = 0.01

    doing: ClassVar[str]  # what the status bar says: "Sinew is ..."
    did: ClassVar[str]
    cancelled: ClassVar[str]

    frame_start: once(IntProperty, min=-MAX_FRAME, max=MAX_FRAME).named(
        "Start", "Set the first frame; if it is not given, the first frame of the scene"
    )
    frame_end: once(IntProperty, min=-MAX_FRAME, max=MAX_FRAME).named(
        "End", "Set the last frame; if it is not given, the last frame of the scene"
    )
    step: once(IntProperty, default=1, min=1).named(
        "Step", "Take every n-th frame; the frames between are blended"
    )

    @abstractmethod
    def job(self, context: Context) -> Job:
        """The work, which has not begun."""

    def frames(self, context: Context) -> range:
        """The frames to work on. Those of the scene are used if none are given."""
        for name in ("frame_start", "frame_end"):
            if not self.properties.is_property_set(name):
                setattr(self, name, getattr(context.scene, name))
        return range(self.frame_start, self.frame_end + 1, self.step)

    def draw_frames(self) -> None:
        """Draw the range of frames."""
        frames = self.layout.column(align=True)
        for name in ("frame_start", "frame_end", "step"):
            frames.prop(self, name)

    @reports_errors
    def run(self, context: Context) -> set[str]:
        """Do all the work at once."""
        job = None
        try:
            job = self.job(context)
            done = -1
            while job.step():
                if job.done == done:
                    time.sleep(_PAUSE)
                done = job.done
            self._finish(job)
        finally:
            if job is not None:
                job.cancel()
        return {"FINISHED"}

    @reports_errors
    def begin(self, context: Context) -> set[str]:
        """Begin the work; ``modal`` goes on with it."""
        self._job = self.job(context)
        context.window_manager.progress_begin(0, self._job.total)
        return self.stay(context)

    def modal(self, context: Context, event: Event) -> set[str]:
        if event.type == "ESC" and event.value == "PRESS":
            self._job.cancel()
            self.leave(context)
            self.tell({"WARNING"}, self.cancelled)
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}  # edits meanwhile would change what is computed
        try:
            if self._some_frames(context):
                return {"RUNNING_MODAL"}
            self._finish(self._job)
        except SinewError as error:
            self._job.cancel()
            self.leave(context)
            self.tell({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.leave(context)
        return {"FINISHED"}

    def cancel(self, context: Context) -> None:
        """Blender ends the operator, because another file is opened or the window is closed."""
        if hasattr(self, "_job"):
            self._job.cancel()
            self.leave(context)

    def _some_frames(self, context: Context) -> bool:
        """Compute some frames and show the progress; True while there are more."""
        begin, job = time.perf_counter(), self._job
        done, has_more = -1, True
        while has_more and done != job.done and time.perf_counter() - begin < _SLICE:
            done = job.done
            has_more = job.step()
        context.window_manager.progress_update(job.done)
        context.workspace.status_text_set(
            compat.told(f"Sinew is {self.doing}: {job.done} of {job.total} frames   (Esc cancels)")
        )
        return has_more

    def leave(self, context: Context) -> None:
        context.window_manager.progress_end()
        super().leave(context)

    def _finish(self, job: Job) -> None:
        warnings = job.finish()
        for line in warnings:
            self.tell({"WARNING"}, line)
        if not warnings:
            plural = "" if job.total == 1 else "s"
            self.tell({"INFO"}, f"{self.did} {job.total} frame{plural}")
