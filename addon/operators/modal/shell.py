# SPDX-License-Identifier: GPL-3.0-or-later
"""What every tool needs: a timer, drawing, header, status bar, and a clean end in all cases."""

from collections.abc import Callable
from enum import Enum
from typing import ClassVar, Protocol

import bpy
import numpy as np
from bpy.types import Context, Event, Object, UILayout

from ... import compat
from ...core.errors import SinewError
from ...core.transform.typed_motion import View
from ...session.state.background import Work
from ..reporting import reports_errors
from .staying import StaysInWindow
from .view import view_of

Keys = tuple[tuple[tuple[str, ...], str], ...]  # the icons of keys, and what these keys do


class Outcome(Enum):
    """What the tool does after an event."""

    GO_ON = "GO_ON"
    PASS = "PASS"
    CONFIRMED = "CONFIRMED"
    CANCELLED = "CANCELLED"


class Tool(Protocol):
    """A tool that changes an object. It needs no window, only events like Blender's."""

    pivot: np.ndarray  # (3,) in the world; motions of the mouse are measured at its depth
    notice: str  # an error that does not end the tool

    @property
    def job(self) -> Work | None:
        """The work of a thread, if any."""

    def process(self, obj: Object, event: Event, view: View) -> Outcome:
        """Process an event. ``view`` describes the viewport at this moment."""

    def restore(self, obj: Object) -> None:
        """Put everything back."""


class ViewportTool(StaysInWindow):
    """Mixin for an operator.

    Its ``start`` ends with ``return self.begin(...)``; a ``Tool`` gets the events.
    """

    TICK = 0.05
    KEYS: Keys = ()
    running: ClassVar[bool] = False  # while a tool runs, nothing else needs to be drawn at the mouse

    def invoke(self, context: Context, event: Event) -> set[str]:
        """Run by events in a 3D Viewport, elsewhere by the properties alone."""
        if context.area is None or context.area.type != "VIEW_3D":
            return self.execute(context)
        return self._start(context, event)

    @reports_errors
    def _start(self, context: Context, event: Event) -> set[str]:
        return self.start(context, event)

    def start(self, context: Context, event: Event) -> set[str]:
        """Prepare the tool. A ``SinewError`` is reported and cancels it."""
        raise TypeError(f"{type(self).__name__} does not start")

    def header(self, context: Context) -> str:
        """The text in the header of the viewport."""
        raise TypeError(f"{type(self).__name__} has no header")

    def store_result(self, context: Context) -> None:
        """Store what the tool did as properties, for Adjust Last Operation and scripts.

        Called on confirmation.
        """

    def worked_on(self, context: Context) -> Object | None:
        """The object that the tool changes, while it may: by default the one in Edit Mode."""
        return context.edit_object

    def begin(self, context: Context, tool: Tool, obj: Object, draw: Callable[[], None]) -> set[str]:
        """Run on ``obj`` until the artist confirms or cancels; ``draw`` is called in each 3D Viewport."""
        self.tool = tool
        self.object_name = obj.name
        self._drawing = bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", "POST_PIXEL")
        ViewportTool.running = True
        result = self.stay(context)
        keys = self.KEYS
        context.workspace.status_text_set(lambda header, _context: _draw_keys(header.layout, keys))
        self._write_header(context)
        return result

    def modal(self, context: Context, event: Event) -> set[str]:
        obj = self.worked_on(context)
        if obj is None or obj.name != self.object_name:
            return self._leave(context, {"CANCELLED"})
        if context.area is None or context.area.type != "VIEW_3D":
            self._restore(obj)
            return self._leave(context, {"CANCELLED"})
        try:
            outcome = self.tool.process(obj, event, view_of(context, self.tool.pivot))
        except SinewError as error:
            self.tell({"ERROR"}, str(error))
            self._restore(obj)
            return self._leave(context, {"CANCELLED"})
        if self.tool.notice:
            self.tell({"WARNING"}, self.tool.notice)
            self.tool.notice = ""
        if outcome is Outcome.CONFIRMED:
            self.store_result(context)
            return self._leave(context, {"FINISHED"})
        if outcome is Outcome.CANCELLED:
            return self._leave(context, {"CANCELLED"})
        self._write_header(context)
        return {"PASS_THROUGH"} if outcome is Outcome.PASS else {"RUNNING_MODAL"}

    def cancel(self, context: Context) -> None:
        """Blender ends the tool, for example because its window is closed."""
        obj = self.worked_on(context)
        if obj is not None and obj.name == self.object_name:
            self._restore(obj)
        self._leave(context, {"CANCELLED"})

    def _write_header(self, context: Context) -> None:
        """Write the header as Blender's own transforms do, or the progress of a thread."""
        if context.area is None:
            return
        job = self.tool.job
        if job is None:
            context.area.header_text_set(compat.told(self.header(context)))
            context.area.tag_redraw()
        else:
            context.area.header_text_set(
                compat.told(f"Sinew is working: {job.fraction:.0%} {job.stage}   (Esc cancels)")
            )

    def _restore(self, obj: Object) -> None:
        """Put everything back as far as possible, after an error."""
        try:
            self.tool.restore(obj)
        except SinewError as error:
            self.tell({"WARNING"}, str(error))

    def _leave(self, context: Context, result: set[str]) -> set[str]:
        ViewportTool.running = False
        self.leave(context)
        bpy.types.SpaceView3D.draw_handler_remove(self._drawing, "WINDOW")
        if context.area is not None:
            context.area.header_text_set(None)
            context.area.tag_redraw()
        return result


def _draw_keys(layout: UILayout, keys: Keys) -> None:
    """Draw the keys of the tool in the status bar."""
    for icons, text in keys:
        row = layout.row(align=True)
        for icon in icons[:-1]:
            row.label(text="", icon=icon)
        row.label(text=text, icon=icons[-1])
