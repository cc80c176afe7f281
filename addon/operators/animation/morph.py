# SPDX-License-Identifier: GPL-3.0-or-later
"""Morphing between two meshes with the same faces."""

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty
from bpy.types import Context, Object, Operator

from ...core.errors import SinewError
from ...core.methods import METHODS, MeshShape
from ...ids import Operators
from ...properties import field
from ...session.actions import bind, deformers
from ..arguments import once
from ..offered import Offered
from ..reporting import reports_errors
from ..target import LINKED
from ..waiting import BindingOperator

# The method that can go to another shape of its mesh, and the parameter that names this shape.
_METHOD, _SHAPE = next(
    (method.id, parameter.id)
    for method in METHODS
    for parameter in method.parameters
    if isinstance(parameter, MeshShape)
)


class SINEW_OT_morph(Offered, BindingOperator, Operator):
    """Morph the active mesh to the other selected mesh, which has the same faces.

    Both meshes count without modifiers and shape keys. The setting Morph of the deformer can be keyed;
    handles move what is between
    """

    bl_idname = Operators.MORPH
    bl_label = "Morph to a Mesh"

    target: once(StringProperty).named(
        "Target Shape", "Give the name of the mesh object to morph to; if empty, the other selected one"
    )
    morph: field(FloatProperty, default=1.0, min=0.0, max=1.0).named(
        "Morph", "Set how far to morph, from 0 to 1"
    )
    key: once(BoolProperty, default=False).named(
        "Key", "Key Morph from 0 at the first frame of the scene to the value above at the last one"
    )

    @classmethod
    def refusal(cls, context: Context) -> str:
        obj = context.object
        if obj is None or obj.type != "MESH" or obj.mode != "OBJECT":
            return "In Object Mode, select the mesh to morph to, then the one to morph"
        return "" if obj.library is None else LINKED

    def draw(self, _context: Context) -> None:
        self.layout.use_property_split = True
        self.layout.prop_search(self, "target", bpy.data, "objects")
        self.layout.prop(self, "morph")
        self.layout.prop(self, "key")

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        obj, other = context.object, self._other(context)
        deformer = obj.sinew.active
        is_new = deformer is None or deformer.method != _METHOD
        if is_new:
            deformer = deformers.add_deformer(obj, _METHOD)
        settings = getattr(deformer, _METHOD)
        before = getattr(settings, _SHAPE), settings.morph
        setattr(settings, _SHAPE, other)
        settings.morph = self.morph
        try:
            bind.bind(obj, deformer, wait)
        except SinewError:
            setattr(settings, _SHAPE, before[0])
            settings.morph = before[1]
            if is_new:
                deformers.remove_deformer(obj, len(obj.sinew.deformers) - 1)
            raise
        if self.key:
            for frame, value in ((context.scene.frame_start, 0.0), (context.scene.frame_end, self.morph)):
                settings.morph = value
                settings.keyframe_insert("morph", frame=frame)
        self.report_state(deformer.uid)
        return {"FINISHED"}

    def _other(self, context: Context) -> Object:
        if self.target:
            found = bpy.data.objects.get(self.target)
            if found is None:
                raise SinewError(f"There is no object {self.target}")
        else:
            others = [obj for obj in context.selected_objects if obj != context.object]
            if len(others) != 1:
                raise SinewError("Select the mesh to morph to, then the one to morph, and no other object")
            found = others[0]
            self.target = found.name
        if found.type != "MESH" or found == context.object:
            raise SinewError(
                f"{context.object.name} cannot morph to {found.name} - choose another mesh object"
            )
        return found
