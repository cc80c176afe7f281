# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of a bake and, once a deformer is baked, the record that unbaking needs."""

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, IntProperty, StringProperty
from bpy.types import PropertyGroup

from .setting import option, record

MAX_FRAME = 1_048_574  # Blender's own limit
FRAMES = {"min": -MAX_FRAME, "max": MAX_FRAME}
_ALEMBIC = "One Alembic file of the result, for other programs; the deformer stays live"

BAKE_TARGETS = (
    (
        "SHAPE_KEYS",
        "Shape Keys",
        "One keyframed shape key per frame, inside the .blend file",
        "SHAPEKEY_DATA",
        1,
    ),
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

    target: option(EnumProperty, items=BAKE_TARGETS, default="PC2").named(
        "Target", "Choose where the baked shapes go"
    )
    custom_range: option(BoolProperty).named(
        "Custom Range", "Bake another range of frames than that of the scene"
    )
    frame_start: option(IntProperty, default=1, **FRAMES).named("Start", "Set the first frame to bake")
    frame_end: option(IntProperty, default=250, **FRAMES).named("End", "Set the last frame to bake")
    step: option(IntProperty, default=1, min=1).named(
        "Step", "Bake every n-th frame; the frames between are blended"
    )
    exact_keys: option(BoolProperty, default=True).named(
        "Exact",
        "Make each frame exact to the last bit by one more shape key that cancels the basis; "
        "turn it off for game engines",
    )

    result: record(
        EnumProperty,
        name="Baked To",
        items=(("NONE", "Not Baked", "The deformer is live", "NONE", 0), *BAKE_TARGETS),
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
        """Whether baked shapes are shown instead of the deformer."""
        return self.result in ("SHAPE_KEYS", "PC2", "MDD")

    @property
    def wanted(self) -> str:
        """The target. A file may hold an unknown number, for which Blender gives an empty text."""
        return self.target or "PC2"

    @property
    def summary(self) -> str:
        """The status line of a baked deformer."""
        frames = f"frames {self.first}-{self.last}" if self.last > self.first else f"frame {self.first}"
        return f"Baked {frames}"
