# SPDX-License-Identifier: GPL-3.0-or-later
"""The shell of a tool that runs in Edit Mode: timer, drawing, header, status bar, and every way out."""

from collections.abc import Callable
from enum import Enum
from typing import Protocol

import bpy
import numpy as np
from bpy.types import Context, Event, Object, UILayout

from ...core.errors import SinewError
from ...core.transform.typed_motion import View
from ...session import Work
from .view import view_of

_TICK = 0.05  # seconds between two looks at threads and previews

Keys = tuple[tuple[tuple[str, ...], str], ...]  # icons, and what these keys do


class Outcome(Enum):
    """What an event led to."""

    GO_ON = "GO_ON"
    PASS = "PASS"
    CONFIRMED = "CONFIRMED"
    CANCELLED = "CANCELLED"


class Tool(Protocol):
    """What has the mesh in hand. It needs no window, only events like Blender's."""

    pivot: np.ndarray  # (3,) in the world: depths are measured there
    notice: str  # a refusal that did not end the tool

    @property
    def job(self) -> Work | None:
        """What a thread works out."""

    def process(self, obj: Object, event: Event, view: View) -> Outcome:
        """Take an event in. ``view`` is how the mesh is seen now."""

    def restore(self, obj: Object) -> None:
        """Put everything back."""


class ViewportTool:
    """Mixed into an operator: ``begin`` ends its ``invoke``, and a ``Tool`` gets the events from there on."""

    KEYS: Keys = ()

    def header(self, context: Context) -> str:
        """What the header of the viewport says."""
        raise TypeError(f"{type(self).__name__} has no header")

    def keep(self) -> None:
        """The tool is confirmed: store what it did as properties, for Adjust Last Operation and scripts."""

    def begin(self, context: Context, tool: Tool, draw: Callable[[], None]) -> set[str]:
        """Run until the artist confirms or cancels; ``draw`` is called in each 3D Viewport."""
        self.tool = tool
        self._name = context.edit_object.name
        manager = context.window_manager
        self._timer = manager.event_timer_add(_TICK, window=context.window)
        self._drawing = bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", "POST_PIXEL")
        manager.modal_handler_add(self)
        keys = self.KEYS
        context.workspace.status_text_set(lambda header, _context: _draw_keys(header.layout, keys))
        self._speak(context)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        obj = context.edit_object
        if obj is None or obj.name != self._name:
            return self._leave(context, {"CANCELLED"})
        if context.area is None or context.area.type != "VIEW_3D":
            self._restore(obj)
            return self._leave(context, {"CANCELLED"})
        try:
            outcome = self.tool.process(obj, event, view_of(context, self.tool.pivot))
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            self._restore(obj)
            return self._leave(context, {"CANCELLED"})
        if self.tool.notice:
            self.report({"WARNING"}, self.tool.notice)
            self.tool.notice = ""
        if outcome is Outcome.CONFIRMED:
            self.keep()
            return self._leave(context, {"FINISHED"})
        if outcome is Outcome.CANCELLED:
            return self._leave(context, {"CANCELLED"})
        self._speak(context)
        return {"PASS_THROUGH"} if outcome is Outcome.PASS else {"RUNNING_MODAL"}

    def cancel(self, context: Context) -> None:
        """Blender ends the tool, as with its window."""
        obj = context.edit_object
        if obj is not None and obj.name == self._name:
            self._restore(obj)
        self._leave(context, {"CANCELLED"})

    def _speak(self, context: Context) -> None:
        """The header, as Blender's own transforms write it, or the progress of a thread."""
        if context.area is None:
            return
        job = self.tool.job
        if job is None:
            context.area.header_text_set(self.header(context))
            context.area.tag_redraw()
        else:
            context.area.header_text_set(f"Sinew is working: {job.fraction:.0%} {job.stage}   (Esc cancels)")

    def _restore(self, obj: Object) -> None:
        """After an error: what can be put back is put back."""
        try:
            self.tool.restore(obj)
        except SinewError as error:
            self.report({"WARNING"}, str(error))

    def _leave(self, context: Context, result: set[str]) -> set[str]:
        context.window_manager.event_timer_remove(self._timer)
        bpy.types.SpaceView3D.draw_handler_remove(self._drawing, "WINDOW")
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        if context.area is not None:
            context.area.header_text_set(None)
            context.area.tag_redraw()
        return result


def _draw_keys(layout: UILayout, keys: Keys) -> None:
    """The status bar while the tool runs."""
    for icons, text in keys:
        row = layout.row(align=True)
        for icon in icons[:-1]:
            row.label(text="", icon=icon)
        row.label(text=text, icon=icons[-1])
