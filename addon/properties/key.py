# SPDX-License-Identifier: GPL-3.0-or-later
"""A key of a deformer: how its handles are edited in one frame of an animation."""

from bpy.props import FloatVectorProperty, IntProperty, StringProperty
from bpy.types import PropertyGroup

from .bake import MAX_FRAME
from .setting import record, setting, setting_list


class SinewEdit(PropertyGroup):
    """How a handle is edited at a key"""

    handle: record(StringProperty, description="The key of the handle")
    edit: record(
        FloatVectorProperty,
        name="Edit",
        size=12,
        description="Three rows of an affine map, in the frame that moves with the handle",
    )


class SinewKey(PropertyGroup):
    """The edits of the handles in one frame"""

    frame: setting(
        IntProperty,
        options=set(),  # cannot be animated
        name="Frame",
        min=-MAX_FRAME,
        max=MAX_FRAME,
        description="Move the key by changing its frame",
    )
    edits: setting_list(type=SinewEdit)
