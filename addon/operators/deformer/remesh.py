# SPDX-License-Identifier: GPL-3.0-or-later
"""New triangles for a mesh: even, fewer, subdivided, or without needles. All that it carries comes along."""

import math
from collections.abc import Callable, Hashable
from functools import partial
from typing import Any, ClassVar

import bpy
import numpy as np
from bpy.props import BoolProperty, FloatProperty, IntProperty
from bpy.types import Context, Event, Object, Operator

from ... import backend, compat
from ...core.errors import SinewError
from ...ids import Operators
from ...properties import deformers_of, field
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

_SECONDS = 6e-5  # for each triangle, about
_LENGTH = partial(distance, default=0.0, precision=4)
_MOST = 20_000_000  # triangles that the native module makes


class _MakesTriangles(OnTarget, StaysInWindow):
    """Base of these operators. In a window, a thread works if that takes long, and Esc cancels."""

    MESHES_ONLY = True
    MAKE: ClassVar[Callable[..., backend.Carried]]
    OPTIONS: ClassVar[tuple[str, ...]]  # names of properties that it takes

    angle: field(FloatProperty, subtype="ANGLE", default=math.radians(45), min=0.01, max=math.pi).named(
        "Fold Angle",
        "Keep long folds that are sharper, beside seams, sharp or creased edges and borders of materials",
    )

    _work: Work | None = None
    _name = ""  # of the object
    _mesh: Hashable = None  # the key of its mesh
    _taken: carrying.Taken

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or _refusal_of(target_of(context))

    def arguments(self, _obj: Object) -> dict[str, Any]:
        """The arguments of ``MAKE``, in the frame of the object."""
        return {name: getattr(self, name) for name in self.OPTIONS}

    def expected(self, obj: Object) -> float:
        """About how many triangles there will be, or infinity if nobody knows before."""
        return _triangles(obj)

    def execute(self, context: Context) -> set[str]:
        return self._begin(context, may_wait=False)

    def invoke(self, context: Context, _event: Event) -> set[str]:
        return self._begin(context, may_wait=True)

    @reports_errors
    def _begin(self, context: Context, may_wait: bool) -> set[str]:
        obj = target_of(context)
        with object_mode(context, obj):
            taken, expected = carrying.take(obj), self.expected(obj)
            make = partial(self.MAKE, taken, **self.arguments(obj))
            if not (may_wait and binding.may_wait(_SECONDS * max(expected, _triangles(obj)))):
                return self._put(context, obj, taken, make())
            self._taken, self._name, self._mesh = taken, obj.name, compat.session_key(obj.data)
        self._work = Work(make)
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
        obj = user_of(self._mesh, self._name)
        with object_mode(context, obj):
            return self._put(context, obj, self._taken, work.result)

    def _put(self, context: Context, obj: Object, taken: carrying.Taken, made: backend.Carried) -> set[str]:
        if obj.data.is_editmode:  # of an object that is not active
            raise SinewError(f"{obj.data.name} is in Edit Mode - leave it first")
        before, scale = _triangles(obj), obj.matrix_world.median_scale
        carrying.put(obj, taken, made)
        more = f", {made.told}" if made.told else ""
        self.tell(
            {"INFO"},
            f"{len(made.faces):,} triangles instead of {before:,}{more}; at most "
            f"{scale * made.distance:.3g} away from the old surface",
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


def user_of(mesh: Hashable, name: str) -> Object:
    """The object of this name that uses the mesh with this key, or else any other one that does."""
    users = [obj for obj in bpy.data.objects if obj.type == "MESH" and compat.session_key(obj.data) == mesh]
    if not users:
        raise SinewError(f"The mesh of {name} is gone")
    return min(users, key=lambda obj: obj.name != name)


def _refusal_of(obj: Object) -> str:
    baked = [deformer.name for deformer in deformers_of(obj) if deformer.bake.is_baked]
    if baked:
        return f"{baked[0]} is baked - Unbake it first"
    return "" if obj.mode in ("OBJECT", "EDIT") else "This works in Object and Edit Mode"


def _triangles(obj: Object) -> int:
    """How many triangles the faces of a mesh are."""
    return len(obj.data.loops) - 2 * len(obj.data.polygons)


class SINEW_OT_remesh(_MakesTriangles, Operator):
    """Give the mesh triangles of even size and shape, on the same surface.

    Vertex groups, UV maps with seams, materials, shape keys and marked edges come along
    """

    bl_idname = Operators.REMESH
    bl_label = "Remesh Evenly"
    MAKE = staticmethod(backend.remesh)
    OPTIONS = ("rounds", "angle")

    by_curvature: field(BoolProperty).named(
        "By Curvature", "Make triangles small where the surface bends, and large where it is flat"
    )
    length: _LENGTH("Edge Length", "Set how long edges should be; at 0, the share below counts")
    share: field(FloatProperty, default=1.0, min=0.05, max=20.0, soft_max=4.0).named(
        "Share", "Set how long edges should be; at 1, there are about as many triangles as before"
    )
    tolerance: _LENGTH(
        "Tolerance", "Set how far triangles may be from the surface; at 0, a thousandth of its size"
    )
    shortest: _LENGTH("Shortest", "Set how short edges may become; at 0, twice the tolerance")
    longest: _LENGTH("Longest", "Set how long edges may become; at 0, a tenth of the size")
    rounds: field(IntProperty, default=3, min=1, max=50, soft_max=10).named(
        "Rounds", "Set how often edges are split, joined and flipped; more rounds are more even"
    )

    def draw(self, _context: Context) -> None:
        """What counts."""
        of_lengths = ("tolerance", "shortest", "longest") if self.by_curvature else ("length", "share")
        layout = self.layout
        layout.use_property_split = True
        for name in ("by_curvature", *of_lengths, "rounds", "angle"):
            layout.prop(self, name)

    def arguments(self, obj: Object) -> dict[str, Any]:
        scale = obj.matrix_world.median_scale or 1.0
        bounds = (length / scale for length in (self.tolerance, self.shortest, self.longest))
        lengths = backend.EdgeLengths(self.length / scale, self.share, self.by_curvature, *bounds)
        return super().arguments(obj) | {"lengths": lengths}

    def expected(self, obj: Object) -> float:
        if self.by_curvature:
            return math.inf
        length = self.length / (obj.matrix_world.median_scale or 1.0)
        if not length:
            return _triangles(obj) / self.share**2
        areas = np.empty(len(obj.data.polygons), dtype=np.float32)
        obj.data.polygons.foreach_get("area", areas)
        return float(areas.sum()) / (math.sqrt(3) / 4 * length**2)


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
        "Base Faces",
        "Set how many triangles are split; at 0, the last level has as many as the mesh now, or more: the "
        "base keeps at least 500",
    )

    def expected(self, obj: Object) -> float:
        """As many as there are at least: kept lines can need a larger base."""
        count, split = _triangles(obj), 4**self.levels
        expected = split * (min(self.base_faces, count) or max(4, count // split, min(count // 4, 500)))
        if expected > _MOST:
            raise SinewError(f"These levels have {expected:,} triangles, and {_MOST:,} are the most")
        return expected
