# SPDX-License-Identifier: GPL-3.0-or-later
"""What a pose bone does while another bone of its puppet is dragged."""

from bpy.props import BoolProperty
from bpy.types import PropertyGroup

from .setting import option


class SinewBone(PropertyGroup):
    """What a pose bone does while another one is dragged"""

    pin: option(BoolProperty).named(
        "Pin", "Keep this bone where it is while Sinew Drag moves another one, as a foot on the ground"
    )
