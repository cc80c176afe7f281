# SPDX-License-Identifier: GPL-3.0-or-later
"""A region of the mesh, its role and its control."""

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import Context, Mesh, Object, PropertyGroup

from ..core.methods import HANDLE_PARAMETERS
from ..core.names import without_number
from .parameters import declare
from .setting import SHARE, affine_map, evaluate_again, matrix, option, record, setting

HANDLE_ROLES = (
    ("HANDLE", "Handle", "Follows a control: an empty, any object, or a bone", "EMPTY_AXIS", 0),
    ("FIXED", "Still", "Stays where it is", "PINNED", 1),
    (
        "SUPPORT",
        "Free Area",
        "May move, while everything outside of it and of the handles holds still",
        "MOD_MESHDEFORM",
        2,
    ),
)

STANDS_ON = (
    (
        "WORLD",
        "World",
        "The control stays where you put it, and what it moves is added to what bones and shape keys do",
        0,
    ),
    (
        "SURFACE",
        "Surface",
        "The control rides on the surface that bones and shape keys move; its pose is kept there",
        1,
    ),
)

ACTS_AS = (
    ("PLACE", "Place", "It moves, turns and scales the space around the place of the object or the bone", 0),
    (
        "POINTS",
        "Points",
        "Each point of the object goes where its edits, shape keys and modifiers take it, and space with it; "
        "of a bone, its head and its tail",
        1,
    ),
    (
        "SEGMENTS",
        "Segments",
        "The whole length of each edge between the points takes space along; of a bone, from head to tail",
        2,
    ),
)


def _renamed(handle: "SinewHandle", _context: Context) -> None:
    """Rename the vertex group and the empty that were made for the region and still carry its old name."""
    before, handle.named = handle.named or handle.vertex_group, handle.name
    obj, new = handle.id_data, handle.name
    if before in (new, "") or not new:
        return
    if handle.owns_group and handle.vertex_group == before and obj.data.library is None:
        obj.sinew.rename_group(before, new)
    control = handle.control
    if control is None or not handle.owns_control or control.library is not None:
        return
    if f"{obj.name} {before}" in (control.name, without_number(control.name)):
        control.name = f"{obj.name} {new}"


def _control_changed(handle: "SinewHandle", context: Context) -> None:
    handle.has_rest, handle.rest = False, None
    evaluate_again(handle, context)


class SinewHandle(PropertyGroup):
    """A region of the mesh, its role and its control"""

    uid: record(StringProperty)
    name: setting(StringProperty, update=_renamed, default="Handle").named(
        "Name",
        "Name the region, and the vertex group and the empty that were made for it; with a "
        "side at the end, as in Hand L, it has a mirror image",
    )
    named: record(StringProperty, description="The name that the region had before it is renamed")
    kind: setting(EnumProperty, items=HANDLE_ROLES, default="HANDLE").named(
        "Role", "Say whether the region follows a control, holds still, or is all that may move"
    )
    vertex_group: setting(StringProperty).named(
        "Vertex Group",
        "Choose the vertices of this region and their weights: 1 holds a vertex exactly, a "
        "lower weight lets it give way",
    )
    control: setting(PointerProperty, type=Object, update=_control_changed).named(
        "Control", "Choose the object that moves this region"
    )
    bone: setting(StringProperty, update=_control_changed).named(
        "Bone", "Choose the pose bone that moves this region, if the control is an armature"
    )
    acts_as: setting(EnumProperty, options=set(), items=ACTS_AS).named(
        "Acts As",
        "Choose where a handle without a vertex group takes hold: at a place, at points, or along lines",
    )
    stands_on: setting(EnumProperty, options=set(), items=STANDS_ON).named(
        "Stands On",
        "Choose whether the control stays in the world, or rides on the surface that modifiers "
        "before Sinew move",
    )
    owns_control: record(
        BoolProperty, description="Whether the control was made for this handle, and is removed with it"
    )
    owns_group: record(
        BoolProperty, description="Whether the vertex group was made for this handle, and is removed with it"
    )
    weight: setting(FloatProperty, **SHARE).named(
        "Weight",
        "Let the region give way by a weight below 1, which multiplies the weights of its vertex group",
    )
    enabled: setting(BoolProperty, default=True).named(
        "Use", "Use this region; if it is off, its vertices are free"
    )
    from_rest: setting(BoolProperty).named(
        "From Rest",
        "Avoid moving twice what the bone of the handle has moved already, by moving the rest shape",
    )
    colour: option(FloatVectorProperty, subtype="COLOR", default=(0.9, 0.5, 0.1), min=0.0, max=1.0).named(
        "Colour", "Colour the region in the list and in the viewport; it does not affect the shape"
    )
    has_rest: record(BoolProperty)
    rest: record(
        PointerProperty,
        type=Mesh,
        description="The points of the control at rest, in the object space of the target, if these count",
    )
    rest_matrix: matrix("Rest Matrix", "The matrix of the control relative to the mesh object, at rest")
    stood_on: record(
        EnumProperty,
        items=STANDS_ON,
        description="What the rest matrices refer to: they follow Stands On in the next evaluation",
    )
    stand_matrix: matrix(
        "Stand Matrix", "What carries the control on the surface at rest, relative to the mesh object"
    )

    has_last_pose: record(BoolProperty)
    last_pose: affine_map(
        "Last Pose",
        "The pose that the region keeps while its control is missing: three rows of an affine map",
    )

    @property
    def control_missing(self) -> bool:
        """Whether the control of the handle, or its bone, was deleted."""
        if self.kind != "HANDLE":
            return False
        control = self.control
        if control is None or not any(control.name in scene.objects for scene in bpy.data.scenes):
            return True
        return bool(self.bone) and (control.pose is None or self.bone not in control.pose.bones)

    @property
    def control_label(self) -> str:
        """The text in the list: the control, or the vertex group of a region without one."""
        if self.control_missing:
            return "control missing"
        if self.control is None:
            return self.vertex_group
        return f"{self.control.name} > {self.bone}" if self.bone else self.control.name


for _parameter in HANDLE_PARAMETERS:
    SinewHandle.__annotations__[_parameter.id] = declare(_parameter)
