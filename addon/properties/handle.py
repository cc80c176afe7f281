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

from ..core.methods import HANDLE_PARAMETERS
from .parameters import declare
from .setting import record, reshape, setting

ROLES = (
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


def _control_changed(handle: "SinewHandle", context: Context) -> None:
    handle.has_rest = False
    reshape(handle, context)


class SinewHandle(PropertyGroup):
    """A region of the mesh and what moves it"""

    uid: record(StringProperty)
    name: setting(
        StringProperty,
        update=None,
        name="Name",
        default="Handle",
        description="What the list calls the region; ends in .L or .R where it has a mirror image",
    )
    kind: setting(
        EnumProperty,
        name="Kind",
        items=ROLES,
        default="HANDLE",
        description="Whether the vertices follow a control, stay, or are the only ones that may move",
    )
    vertex_group: setting(
        StringProperty,
        name="Vertex Group",
        description="The vertices of this region, by their weights: 1 holds a vertex exactly, "
        "less lets it give way",
    )
    control: setting(
        PointerProperty,
        name="Control",
        type=Object,
        description="The object that moves this region",
        update=_control_changed,
    )
    bone: setting(
        StringProperty,
        name="Bone",
        description="The pose bone that moves this region, where the control is an armature",
        update=_control_changed,
    )
    owns_control: record(BoolProperty, description="The control was made for this handle, and goes with it")
    owns_group: record(
        BoolProperty, description="The vertex group was made for this handle, and goes with it"
    )
    weight: setting(
        FloatProperty,
        name="Weight",
        default=1.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        description="1 holds the region exactly, less lets it give way, 0 lets it go. "
        "Multiplied by the weights of the vertex group",
    )
    enabled: setting(
        BoolProperty, name="Use", default=True, description="Use this region; off, its vertices are free"
    )
    from_rest: setting(
        BoolProperty,
        name="From Rest",
        description="Move the rest shape instead of the posed one. "
        "For a handle on the same bone that already moved the mesh",
    )
    colour: setting(
        FloatVectorProperty,
        update=None,
        name="Colour",
        subtype="COLOR",
        default=(0.9, 0.5, 0.1),
        min=0.0,
        max=1.0,
        description="How the region is shown in the list and in overlays; it changes no shape",
    )
    has_rest: record(BoolProperty)
    rest_matrix: record(
        FloatVectorProperty,
        name="Rest Matrix",
        size=16,
        subtype="MATRIX",
        description="The control relative to the mesh object, when the region is at rest",
    )

    has_last_pose: record(BoolProperty)
    last_pose: record(
        FloatVectorProperty,
        name="Last Pose",
        size=12,
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


for _parameter in HANDLE_PARAMETERS:
    SinewHandle.__annotations__[_parameter.id] = declare(_parameter)
