# SPDX-License-Identifier: GPL-3.0-or-later
"""How a deformer is baked, and, once it is, where the baked shapes are and how to take them back."""

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, IntProperty, StringProperty
from bpy.types import PropertyGroup

_OVERRIDE = {"LIBRARY_OVERRIDABLE"}
_LIST = {"LIBRARY_OVERRIDABLE", "USE_INSERTION"}
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

    target: EnumProperty(
        name="Target",
        items=TARGETS,
        default="PC2",
        override=_OVERRIDE,
        description="Where the baked shapes go",
    )
    custom_range: BoolProperty(
        name="Custom Range",
        override=_OVERRIDE,
        description="Bake other frames than the scene's range",
    )
    frame_start: IntProperty(
        name="Start",
        default=1,
        min=-MAX_FRAME,
        max=MAX_FRAME,
        override=_OVERRIDE,
        description="First frame to bake",
    )
    frame_end: IntProperty(
        name="End",
        default=250,
        min=-MAX_FRAME,
        max=MAX_FRAME,
        override=_OVERRIDE,
        description="Last frame to bake",
    )
    step: IntProperty(
        name="Step",
        default=1,
        min=1,
        override=_OVERRIDE,
        description="Bake every so many frames; the frames between are blended",
    )
    exact_keys: BoolProperty(
        name="Exact",
        default=True,
        override=_OVERRIDE,
        description="One more shape key takes the basis out, so that Blender's sum of keys gives each frame "
        "to the last bit. Off, the keys are ordinary ones for game engines, right to a millionth of the size",
    )

    result: EnumProperty(
        name="Baked To",
        items=(("NONE", "Not Baked", "The deformer is live", "NONE", 0), *TARGETS),
        options={"HIDDEN"},
        override=_OVERRIDE,
    )
    first: IntProperty(options={"HIDDEN"}, override=_OVERRIDE)
    last: IntProperty(options={"HIDDEN"}, override=_OVERRIDE)
    filepath: StringProperty(
        name="Cache File",
        options={"HIDDEN"},
        override=_OVERRIDE,
        description="The file that the Mesh Cache modifier plays",
    )
    modifier: StringProperty(options={"HIDDEN"}, override=_OVERRIDE)
    keys: CollectionProperty(type=SinewBakedKey, options={"HIDDEN"}, override=_LIST)
    made_basis: BoolProperty(options={"HIDDEN"}, override=_OVERRIDE)
    made_action: BoolProperty(options={"HIDDEN"}, override=_OVERRIDE)
    show_viewport: BoolProperty(options={"HIDDEN"}, override=_OVERRIDE)
    show_render: BoolProperty(options={"HIDDEN"}, override=_OVERRIDE)

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
