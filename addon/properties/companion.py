# SPDX-License-Identifier: GPL-3.0-or-later
"""One of the objects that share handles with the target of a deformer."""

from bpy.props import BoolProperty, PointerProperty
from bpy.types import Mesh, PropertyGroup

from .setting import matrix, record


class SinewCompanion(PropertyGroup):
    """An object that shares handles"""

    is_target: record(BoolProperty, description="Whether it is the target itself, whose rest shape counts")
    rest: record(PointerProperty, type=Mesh, description="The rest shape of another object")
    frame: matrix("Frame", "From the stored rest shape to the frame that all of the objects have in common")
