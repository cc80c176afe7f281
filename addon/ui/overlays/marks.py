# SPDX-License-Identifier: GPL-3.0-or-later
"""Marks in the viewports: discs on pinned bones, lines from riding controls to where they rest, and curves on
the smooth surface of a cage.
"""

from collections.abc import Iterator

import numpy as np
from bpy.types import Context, GizmoGroup, Object
from bpy.utils import register_classes_factory

from ... import compat
from ...operators import ring
from ...properties import SinewDeformer
from ...session.controls.cage import smooth
from ...session.controls.handles import riding
from ..drag_tool import is_hand_tool
from ..places import active_deformer
from .reach import OverViewports, SINEW_GT_lines

_DISC = 0.12  # of the length of a bone
_PINNED, _RIDING, _SMOOTH = (1.0, 0.25, 0.1), (0.6, 0.6, 0.6), (1.0, 0.6, 0.1)


def pins(armature: Object, toward: np.ndarray) -> list[np.ndarray]:
    """Discs (k, 3) of the world that face the viewer, ``toward`` (3,), at both ends of each pinned bone."""
    found = []
    for bone in armature.pose.bones:
        if bone.sinew.pin and compat.is_bone_visible(armature, bone.name):
            head, tail = (np.array(armature.matrix_world @ end) for end in (bone.head, bone.tail))
            size = _DISC * float(np.linalg.norm(tail - head))
            found += [ring(place, toward, size) for place in (head, tail)]
    return found


def rests(obj: Object, deformer: SinewDeformer) -> Iterator[np.ndarray]:
    """Lines (2, 3) of the world from each control that rides to where it rests on the surface."""
    for handle in deformer.handles:
        if handle.kind == "HANDLE" and riding.is_carried(obj, handle):
            carried = obj.matrix_world @ handle.control.matrix_parent_inverse
            yield np.array((handle.control.matrix_world.translation, carried.translation))


class SINEW_GGT_marks(OverViewports, GizmoGroup):
    """Pinned bones, and where riding controls rest"""

    bl_idname = "SINEW_GGT_marks"
    bl_label = "Marks of Sinew's Controls"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return is_hand_tool(context)

    def setup(self, _context: Context) -> None:
        self.discs, self.lines = (self.gizmos.new(SINEW_GT_lines.bl_idname) for _ in range(2))
        self.discs.kind = "TRIS"
        for gizmo, colour, alpha in ((self.discs, _PINNED, 0.8), (self.lines, _RIDING, 0.9)):
            gizmo.color, gizmo.alpha, gizmo.line_width = colour, alpha, 1.5
            gizmo.hide_select = True

    def draw_prepare(self, context: Context) -> None:
        obj, deformer = context.object, active_deformer(context)
        toward = np.array(context.region_data.view_matrix, dtype=np.float64)[2, :3]
        is_figure = obj is not None and obj.type == "ARMATURE"
        self.discs.lines = pins(obj, toward) if is_figure else ()
        self.lines.lines = list(rests(deformer.id_data, deformer)) if deformer is not None else ()


class SINEW_GGT_smooth_cage(OverViewports, GizmoGroup):
    """The smooth surface of a cage, along its edges"""

    bl_idname = "SINEW_GGT_smooth_cage"
    bl_label = "Smooth Surface of Sinew's Cage"

    @classmethod
    def poll(cls, context: Context) -> bool:
        deformer = active_deformer(context)
        return deformer is not None and getattr(deformer.parameters, "smooth", "off") != "off"

    def setup(self, _context: Context) -> None:
        self.curves = self.gizmos.new(SINEW_GT_lines.bl_idname)
        self.curves.kind, self.curves.color, self.curves.alpha = "LINES", _SMOOTH, 0.9
        self.curves.hide_select = True
        self.shown: np.ndarray | None = None

    def draw_prepare(self, context: Context) -> None:
        deformer = active_deformer(context)
        curves = None if deformer is None else smooth.curves(deformer)
        if curves is not self.shown:
            self.shown, self.curves.lines = curves, ()
            if curves is not None:
                self.curves.lines = (np.stack((curves[:, :-1], curves[:, 1:]), axis=2).reshape(-1, 3),)
        if deformer is not None:
            self.curves.world = deformer.id_data.matrix_world.copy()


register, unregister = register_classes_factory((SINEW_GGT_marks, SINEW_GGT_smooth_cage))
