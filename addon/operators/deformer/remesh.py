# SPDX-License-Identifier: GPL-3.0-or-later
"""New triangles for a mesh: even, fewer, subdivided, or without needles. All that it carries comes along."""

import math
from collections.abc import Callable
from typing import ClassVar

from bpy.props import FloatProperty, IntProperty
from bpy.types import Context, Event, Object, Operator

from ... import backend, compat
from ...core.errors import SinewError
from ...ids import Operators
from ...properties import field
from ...session.actions import carrying
from ...session.evaluation import binding
from ...session.state.background import Work
from ..arguments import distance
from ..modal.staying import StaysInWindow
from ..offered import OnTarget
from ..reporting import reports_errors
from ..target import object_mode, target_of
from ..waiting import redraw_panels
from .repair import bind_again

_SECONDS = 6e-5  # for each vertex, about


class _MakesTriangles(OnTarget, StaysInWindow):
    """Base of these operators. In a window, a thread works if that takes long, and Esc cancels."""

    MESHES_ONLY = True
    MAKE: ClassVar[Callable[..., backend.Carried]]
    OPTIONS: ClassVar[tuple[str, ...]]  # names of properties that it takes

    angle: field(FloatProperty, subtype="ANGLE", default=math.radians(45), min=0.01, max=math.pi).named(
        "Fold Angle",
        "Keep folds that are sharper, beside seams, sharp and creased edges and the borders of materials",
    )

    _work: Work | None = None
    _name = ""  # of the object
    _taken: carrying.Taken

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            "" if target_of(context).mode in ("OBJECT", "EDIT") else "This works in Object and Edit Mode"
        )

    def maker(self, taken: carrying.Taken) -> Callable[[backend.Progress | None], backend.Carried]:
        """A function that makes the triangles, in any thread."""
        options = {name: getattr(self, name) for name in self.OPTIONS}
        return lambda progress: self.MAKE(taken, progress, **options)

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        with object_mode(context, obj):
            taken = carrying.take(obj)
            return self._put(context, obj, taken, self.maker(taken)(None))

    def invoke(self, context: Context, _event: Event) -> set[str]:
        obj = target_of(context)
        wait = binding.may_wait(_SECONDS * len(obj.data.vertices))
        return self._begin(context, obj) if wait else self.execute(context)

    @reports_errors
    def _begin(self, context: Context, obj: Object) -> set[str]:
        with object_mode(context, obj):
            self._taken, self._name = carrying.take(obj), obj.name
        self._work = Work(self.maker(self._taken))
        return self.stay(context)

    def modal(self, context: Context, event: Event) -> set[str]:
        if event.type == "TIMER":
            redraw_panels()
        result = self._look(context, event.type == "ESC" and event.value == "PRESS")
        if "PASS_THROUGH" not in result:
            self.leave(context)
        return result

    @reports_errors
    def _look(self, context: Context, is_cancelled: bool) -> set[str]:
        work = self._work
        if is_cancelled:
            self.tell({"WARNING"}, "The mesh stays as it was")
            return {"CANCELLED"}
        if not work.done:
            context.workspace.status_text_set(
                compat.told(f"Sinew is working: {work.fraction:.0%} {work.stage}   (Esc cancels)")
            )
            return {"PASS_THROUGH"}
        if work.error is not None:
            raise work.error
        obj = context.scene.objects.get(self._name)
        if obj is None:
            raise SinewError(f"{self._name} is gone")
        with object_mode(context, obj):
            return self._put(context, obj, self._taken, work.result)

    def _put(self, context: Context, obj: Object, taken: carrying.Taken, made: backend.Carried) -> set[str]:
        before = len(obj.data.polygons)
        carrying.put(obj, taken, made)
        more = f", {made.told}" if made.told else ""
        self.tell(
            {"INFO"},
            f"{len(made.faces):,} faces instead of {before:,}{more}; at most {made.distance:.3g} away from "
            "the old surface",
        )
        bind_again(self, context, obj, True)
        return {"FINISHED"}

    def cancel(self, context: Context) -> None:
        """Blender ends the operator, because its window is closed or another file is opened."""
        self.leave(context)

    def leave(self, context: Context) -> None:
        if self._work is not None:
            self._work.cancel()
        super().leave(context)


class SINEW_OT_remesh(_MakesTriangles, Operator):
    """Give the mesh triangles of even size and shape, on the same surface.

    Vertex groups, UV maps with seams, materials, shape keys and marked edges come along
    """

    bl_idname = Operators.REMESH
    bl_label = "Remesh Evenly"
    MAKE = staticmethod(backend.remesh)
    OPTIONS = ("length", "share", "rounds", "angle")

    length: distance(
        "Edge Length", "Set how long edges should be; at 0, the share below counts", default=0.0, precision=4
    )
    share: field(FloatProperty, default=1.0, min=0.05, max=20.0, soft_max=4.0).named(
        "Share", "Set how long edges should be, as a share of how long they are on average"
    )
    rounds: field(IntProperty, default=3, min=1, max=50, soft_max=10).named(
        "Rounds", "Set how often edges are split, joined and flipped; more rounds are more even"
    )


class SINEW_OT_decimate(_MakesTriangles, Operator):
    """Give the mesh fewer triangles, where it loses least of its shape.

    Vertex groups, UV maps with seams, materials, shape keys and marked edges come along
    """

    bl_idname = Operators.DECIMATE
    bl_label = "Decimate"
    MAKE = staticmethod(backend.decimate)
    OPTIONS = ("share", "angle")

    share: field(FloatProperty, default=0.5, min=0.0001, max=1.0, precision=3).named(
        "Share", "Set how many of the triangles stay"
    )


class SINEW_OT_remove_needles(_MakesTriangles, Operator):
    """Give the mesh triangles without needles, which have a very short side or a very wide angle.

    Vertex groups, UV maps with seams, materials, shape keys and marked edges come along
    """

    bl_idname = Operators.REMOVE_NEEDLES
    bl_label = "Remove Needles"
    MAKE = staticmethod(backend.remove_degenerate)
    OPTIONS = ("ratio", "cap", "angle")

    ratio: field(FloatProperty, default=4.0, min=1.1, soft_max=20.0).named(
        "Ratio", "Take triangles for needles whose longest side is so many times as long as the shortest one"
    )
    cap: field(
        FloatProperty, subtype="ANGLE", default=math.radians(160), min=math.radians(91), max=math.pi
    ).named("Widest Angle", "Take triangles for needles that have a wider angle")


class SINEW_OT_remesh_semi_regular(_MakesTriangles, Operator):
    """Give the mesh few large triangles, each split into four several times.

    Vertex groups, UV maps with seams, materials, shape keys and marked edges come along
    """

    bl_idname = Operators.SEMI_REGULAR
    bl_label = "Remesh in Levels"
    MAKE = staticmethod(backend.semi_regular)
    OPTIONS = ("levels", "base_faces", "angle")

    levels: field(IntProperty, default=3, min=1, max=8, soft_max=5).named(
        "Levels", "Set how often each triangle is split into four"
    )
    base_faces: field(IntProperty, default=0, min=0, soft_max=10_000).named(
        "Base Faces", "Set how many triangles are split; at 0, the last level has as many as the mesh now"
    )
