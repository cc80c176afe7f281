# SPDX-License-Identifier: GPL-3.0-or-later
"""Look at a mesh before it is posed: count and select what is unusual about it, and measure how it bends."""

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty
from bpy.types import Context, Object, Operator

from ...ids import Operators
from ...properties import field
from ...session.actions import selection, surveying
from ..offered import OnTarget
from ..reporting import reports_errors
from ..target import object_mode, target_of

_CURVATURES = (
    ("mean", "Mean", "How far the surface bends on average of all directions", 0),
    (
        "gaussian",
        "Gaussian",
        "Positive on domes, negative on saddles, 0 where paper could follow",
        1,
    ),
    ("largest", "Largest", "How far it bends in the direction in which it bends outward most", 2),
    ("smallest", "Smallest", "How far it bends in the direction in which it bends inward most", 3),
    ("none", "No Colours", "Store the attributes alone", 4),
)


class SINEW_OT_diagnose(OnTarget, Operator):
    """Report what is unusual about the mesh, with counts, so that it can be selected and mended.

    This changes nothing
    """

    bl_idname = Operators.DIAGNOSE
    bl_label = "Diagnose"
    bl_options = {"REGISTER"}
    MESHES_ONLY = True

    crossings: field(BoolProperty, default=True).named(
        "Crossings", "Search for faces that pass through each other, too, which takes longest"
    )

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        surveying.survey(obj, self.crossings)
        counts = surveying.last_counts(obj)
        found = [surveying.counted(*each) for each in counts.found.items()]
        parts = "1 part" if counts.parts == 1 else f"{counts.parts:,} parts"
        self.tell({"INFO"}, f"{obj.name}: {', '.join([parts, *found])}")
        return {"FINISHED"}


class SINEW_OT_select_unusual(OnTarget, Operator):
    """Select, in Edit Mode, what is unusual about the mesh in one way.

    The mesh is looked at anew
    """

    bl_idname = Operators.SELECT_UNUSUAL
    bl_label = "Select Unusual"
    MESHES_ONLY = True

    what: field(
        EnumProperty,
        items=tuple(
            (name, several[:1].upper() + several[1:], f"Select each {one}", number)
            for number, (name, (one, several)) in enumerate(surveying.NAMES.items())
        ),
    ).named("What", "Choose what to select")

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or _no_edit_mode(target_of(context))

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        elements = surveying.elements_of(obj, self.what)
        if obj.mode != "EDIT":
            if context.object is not None and context.object.mode != "OBJECT":
                bpy.ops.object.mode_set(mode="OBJECT")
            context.view_layer.objects.active = obj
            bpy.ops.object.mode_set(mode="EDIT")
        count = selection.select_elements(obj, elements)
        noun = elements.element if count == 1 else {"face": "faces", "vertex": "vertices"}[elements.element]
        self.tell({"INFO"}, f"{count:,} {noun} selected")
        return {"FINISHED"}


def _no_edit_mode(obj: Object) -> str:
    held = obj.override_library or obj.data.library or obj.data.override_library
    refused = "Blender edits neither linked meshes nor library overrides - make the object local first"
    return refused if held else ""


class SINEW_OT_measure_curvature(OnTarget, Operator):
    """Show in colour how the mesh bends at each vertex, and store it as attributes of the mesh.

    Geometry nodes and materials can use them
    """

    bl_idname = Operators.CURVATURE
    bl_label = "Measure Curvature"
    MESHES_ONLY = True

    shown: field(EnumProperty, items=_CURVATURES, default="mean").named(
        "Colours", "Choose what the colours show"
    )
    rings: field(IntProperty, default=2, min=1, max=20, soft_max=6).named(
        "Rings", "Smooth the noise of scans by looking at more rings of neighbours of each vertex"
    )
    vectors: field(BoolProperty, default=False).named(
        "Directions", "Store the directions of the largest and of the smallest curvature, too"
    )

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        with object_mode(context, obj):
            least, most, end = surveying.measure_curvature(obj, self.rings, self.shown, self.vectors)
        view = context.space_data
        if self.shown != "none" and view is not None and view.type == "VIEW_3D":
            view.shading.color_type = "VERTEX"
        label = next(label for name, label, *_rest in _CURVATURES if name == self.shown)
        which = "Mean" if self.shown == "none" else label
        colours = "" if self.shown == "none" else f"; blue and red begin at {end:.3g}"
        self.tell({"INFO"}, f"{which} curvature from {least:.3g} to {most:.3g}{colours}")
        return {"FINISHED"}
