# SPDX-License-Identifier: GPL-3.0-or-later
"""A region of the mesh and what moves it."""

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import Context, Object, PropertyGroup

_OVERRIDE = {"LIBRARY_OVERRIDABLE"}

KINDS = (
    ("HANDLE", "Handle", "Follows a control: an empty, any object, or a bone", "EMPTY_AXIS", 0),
    ("FIXED", "Fixed", "Stays where it is", "PINNED", 1),
    (
        "SUPPORT",
        "Support",
        "May move: everything outside of it, and of the handles, is fixed",
        "MOD_MESHDEFORM",
        2,
    ),
)


def _control_changed(handle: "SinewHandle", _context: Context) -> None:
    handle.has_rest = False
    handle.id_data.update_tag(refresh={"OBJECT"})


def _changed(handle: "SinewHandle", _context: Context) -> None:
    handle.id_data.update_tag(refresh={"OBJECT"})


class SinewHandle(PropertyGroup):
    """A region of the mesh and what moves it"""

    uid: StringProperty(options={"HIDDEN"}, override=_OVERRIDE)
    name: StringProperty(
        name="Name",
        default="Handle",
        override=_OVERRIDE,
        description="What the list calls the region; ends in .L or .R where it has a mirror image",
    )
    kind: EnumProperty(
        update=_changed,
        name="Kind",
        items=KINDS,
        default="HANDLE",
        override=_OVERRIDE,
        description="Whether the vertices follow a control, stay, or are the only ones that may move",
    )
    vertex_group: StringProperty(
        name="Vertex Group",
        update=_changed,
        description="The vertices of this region, by their weights: 1 holds a vertex exactly, "
        "less lets it give way",
        override=_OVERRIDE,
    )
    control: PointerProperty(
        name="Control",
        type=Object,
        description="The object that moves this region",
        update=_control_changed,
        override=_OVERRIDE,
    )
    bone: StringProperty(
        name="Bone",
        description="The pose bone that moves this region, where the control is an armature",
        update=_control_changed,
        override=_OVERRIDE,
    )
    owns_control: BoolProperty(
        description="The control was made for this handle, and goes with it",
        options={"HIDDEN"},
        override=_OVERRIDE,
    )
    owns_group: BoolProperty(
        description="The vertex group was made for this handle, and goes with it",
        options={"HIDDEN"},
        override=_OVERRIDE,
    )
    weight: FloatProperty(
        update=_changed,
        name="Weight",
        default=1.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        override=_OVERRIDE,
        description="1 holds the region exactly, less lets it give way, 0 lets it go. "
        "Multiplied by the weights of the vertex group",
    )
    continuity: FloatProperty(
        update=_changed,
        name="Continuity",
        default=2.0,
        min=0.0,
        max=2.0,
        precision=1,
        step=10,
        override=_OVERRIDE,
        description="How smoothly the surface leaves this region: 0 leaves a crease, 1 keeps the slope, "
        "2 keeps the curvature",
    )
    enabled: BoolProperty(
        update=_changed,
        name="Use",
        default=True,
        override=_OVERRIDE,
        description="Use this region; off, its vertices are free",
    )
    from_rest: BoolProperty(
        update=_changed,
        name="From Rest",
        override=_OVERRIDE,
        description="Move the rest shape instead of the posed one. "
        "For a handle on the same bone that already moved the mesh",
    )
    colour: FloatVectorProperty(
        name="Colour",
        subtype="COLOR",
        default=(0.9, 0.5, 0.1),
        min=0.0,
        max=1.0,
        override=_OVERRIDE,
        description="How the region is shown in the list and in overlays; it changes no shape",
    )
    has_rest: BoolProperty(options={"HIDDEN"}, override=_OVERRIDE)
    rest_matrix: FloatVectorProperty(
        name="Rest Matrix",
        size=16,
        subtype="MATRIX",
        options={"HIDDEN"},
        override=_OVERRIDE,
        description="The control relative to the mesh object, when the region is at rest",
    )

    has_last_pose: BoolProperty(options={"HIDDEN"}, override=_OVERRIDE)
    last_pose: FloatVectorProperty(
        name="Last Pose",
        size=12,
        options={"HIDDEN"},
        override=_OVERRIDE,
        description="Where the region stays while its control is missing: three rows of an affine map",
    )

    @property
    def control_missing(self) -> bool:
        """The handle's control was deleted, or its bone is gone."""
        if self.kind != "HANDLE":
            return False
        control = self.control
        if control is None or not any(control.name in scene.objects for scene in bpy.data.scenes):
            return True
        return bool(self.bone) and (control.pose is None or self.bone not in control.pose.bones)

    @property
    def control_label(self) -> str:
        """What the list shows: the control, or how many vertices stay."""
        if self.control_missing:
            return "control missing"
        if self.control is None:
            return self.vertex_group
        return f"{self.control.name} > {self.bone}" if self.bone else self.control.name
