# SPDX-License-Identifier: GPL-3.0-or-later
"""A key of a deformer: how its handles are edited in one frame of an animation."""

from bpy.props import IntProperty, StringProperty
from bpy.types import PropertyGroup

from .bake import FRAMES
from .setting import affine_map, record, setting, setting_list


class SinewEdit(PropertyGroup):
    """How a handle is edited at a key"""

    handle: record(StringProperty, description="The key of the handle")
    edit: affine_map("Edit", "Three rows of an affine map, in the frame that moves with the handle")


class SinewKey(PropertyGroup):
    """The edits of the handles in one frame"""

    frame: setting(IntProperty, options=set(), **FRAMES).named("Frame", "Move the key by changing its frame")
    edits: setting_list(type=SinewEdit)
