# SPDX-License-Identifier: GPL-3.0-or-later
"""How a deformer is baked, and, once it is, where the baked shapes are and how to take them back."""

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, IntProperty, StringProperty
from bpy.types import PropertyGroup

from .setting import record, setting

MAX_FRAME = 1_048_574  # as Blender's own
_ALEMBIC = "One Alembic file of the result, for other programs; the deformer stays live"

TARGETS = (
    ("SHAPE_KEYS", "Shape Keys", "One keyframed shape key a frame, inside the .blend", "SHAPEKEY_DATA", 1),
    ("PC2", "PC2", "A point cache file, played by a Mesh Cache modifier", "FILE_CACHE", 2),
    ("MDD", "MDD", "A point cache file for other programs, played by a Mesh Cache modifier", "FILE_CACHE", 3),
    (
        "ALEMBIC",
        "Alembic",
        _ALEMBIC
        if bpy.app.build_options.alembic
        else "This Blender was built without Alembic - use PC2 or MDD",
        "FILE_3D",
        4,
    ),
)


class SinewBakedKey(PropertyGroup):
    """A shape key that a bake made, by its name"""


class SinewBake(PropertyGroup):
    """Settings of a bake, and the record of one that was made"""

    target: setting(
        EnumProperty,
        update=None,
        name="Target",
        items=TARGETS,
        default="PC2",
        description="Where the baked shapes go",
    )
    custom_range: setting(
        BoolProperty, update=None, name="Custom Range", description="Bake other frames than the scene's range"
    )
    frame_start: setting(
        IntProperty,
        update=None,
        name="Start",
        default=1,
        min=-MAX_FRAME,
        max=MAX_FRAME,
        description="First frame to bake",
    )
    frame_end: setting(
        IntProperty,
        update=None,
        name="End",
        default=250,
        min=-MAX_FRAME,
        max=MAX_FRAME,
        description="Last frame to bake",
    )
    step: setting(
        IntProperty,
        update=None,
        name="Step",
        default=1,
        min=1,
        description="Bake every so many frames; the frames between are blended",
    )
    exact_keys: setting(
        BoolProperty,
        update=None,
        name="Exact",
        default=True,
        description="One more shape key takes the basis out, so that Blender's sum of keys gives each frame "
        "to the last bit. Off, the keys are ordinary ones for game engines, right to a millionth of the size",
    )

    result: record(
        EnumProperty,
        name="Baked To",
        items=(("NONE", "Not Baked", "The deformer is live", "NONE", 0), *TARGETS),
    )
    first: record(IntProperty)
    last: record(IntProperty)
    filepath: record(
        StringProperty, name="Cache File", description="The file that the Mesh Cache modifier plays"
    )
    modifier: record(StringProperty)
    keys: record(CollectionProperty, type=SinewBakedKey)
    made_basis: record(BoolProperty)
    made_action: record(BoolProperty)
    show_viewport: record(BoolProperty)
    show_render: record(BoolProperty)

    @property
    def is_baked(self) -> bool:
        """Baked shapes are shown, and the deformer rests."""
        return self.result in ("SHAPE_KEYS", "PC2", "MDD")

    @property
    def wanted(self) -> str:
        """The target; a file may hold a number that stands for none."""
        return self.target or "PC2"

    @property
    def summary(self) -> str:
        """The status line of a baked deformer."""
        frames = f"frames {self.first}-{self.last}" if self.last > self.first else f"frame {self.first}"
        return f"Baked {frames}"
