# SPDX-License-Identifier: GPL-3.0-or-later
"""A row of one model before one camera: what most samples are, as data."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import bpy
from mathutils import Vector

from . import markers, posing, studio
from .posing import POSE_FRAME, Move

Pose = Callable[[bpy.types.Object], object]


@dataclass(frozen=True)
class Lineup:
    """A sample: ``build`` makes the model, and ``row`` says for each label what poses its copy, if anything.
    With ``anew``, ``build`` makes each of them, of a label and a place along x; without, they are copies. An
    object that gets a property ``label`` while it is posed has that text instead of the key of the row."""

    build: Callable[..., bpy.types.Object]
    row: Mapping[str, Pose | None]
    spacing: float
    shot: studio.Shot
    heading: float = 0.0  # degrees by which each copy is turned
    frame: int = POSE_FRAME  # that the picture shows
    active: int = -1  # which of the row the file opens with
    anew: bool = False
    smooth: bool = False  # a Subdivision below the deformers
    note: Callable[[bpy.types.Object, bpy.types.Object], str] | None = None  # of an object and the first
    finish: Callable[[Sequence[bpy.types.Object]], object] | None = None  # with the posed row
    about: str = ""  # what ``run --list`` says

    def make(self) -> bpy.types.Scene:
        scene = studio.empty_scene()
        places = posing.places(len(self.row), self.spacing)
        if self.anew:
            row = [self.build(label, x) for label, x in zip(self.row, places)]
        else:
            row = posing.line_up(self.build(), self.row, places, self.heading)
        for obj, pose in zip(row, self.row.values()):
            if pose:
                pose(obj)
        if self.finish:
            self.finish(row)
        if self.smooth:
            for obj in row:
                posing.subdivide(obj)
        scene.frame_set(self.frame)
        labels = [obj.get("label", key) for key, obj in zip(self.row, row)]
        self.shot.set_up(scene, zip(labels, places))
        if self.note:
            self.shot.add_notes(scene, [(self.note(obj, row[0]), x) for obj, x in zip(row, places)])
        studio.open_at(scene, self.frame, row[self.active])
        return scene


@dataclass(frozen=True)
class Handle:
    """A handle on a vertex group, how its control moves, and the pin that shows it, from foot to tip."""

    group: str
    moves: Mapping[int, Move]
    tip: Sequence[float]
    foot: Sequence[float]


@dataclass(frozen=True)
class Regions:
    """Poses an object by handles; another vertex group is held. Without a method it only gets its marks."""

    method: str
    handles: Sequence[Handle]
    fixed: str
    parameters: Mapping[str, object] = field(default_factory=dict)
    pin: float = 0.06  # the radius of its ball
    pads: Sequence[tuple[float, float]] = ()  # where what is held stands
    pad: float = 0.25
    thickness: float = 0.0  # given to a sheet below the deformer

    def __call__(self, obj: bpy.types.Object) -> None:
        place = obj.matrix_world.copy()
        for x, y in self.pads:
            markers.add_pad(place @ Vector((x, y, 0.0)), self.pad)
        if self.method:
            posing.add_deformer(obj, self.method, **self.parameters)
            controls = [posing.add_region(obj, "HANDLE", handle.group).control for handle in self.handles]
            posing.add_region(obj, "FIXED", self.fixed)
        else:
            controls = [posing.add_object(f"{handle.group} at rest", None) for handle in self.handles]
        if self.thickness:
            add_thickness(obj, self.thickness)
        for control, handle in zip(controls, self.handles):
            markers.add_pin(control, place @ Vector(handle.tip), self.pin, place @ Vector(handle.foot))
        if self.method:
            for control, handle in zip(controls, self.handles):
                posing.animate(control, handle.moves, obj)
            posing.check_posed(obj)


def add_thickness(obj: bpy.types.Object, thickness: float) -> None:
    """A Solidify below our deformer, so that it sees the posed sheet."""
    thick = obj.modifiers.new("Thickness", "SOLIDIFY")
    thick.thickness, thick.offset = thickness, -1.0


def there_and_back(*moves: tuple[int, Move], end: int = 96) -> dict[int, Move]:
    """Keys of a control that rests at the first frame and at the last."""
    return {1: posing.REST, **dict(moves), end: posing.REST}
