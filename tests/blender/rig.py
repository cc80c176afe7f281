# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes, and what Blender shows of them: of Sinew, only its operators run here."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

FLOAT32 = 4e-6  # a few roundings of coordinates near 1
MATRIX = 1e-5  # a pose that went through location, rotation and scale in float32
CORNERS = [(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]  # of a cube
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def update() -> None:
    """Let Blender evaluate, handlers included."""
    bpy.context.view_layer.update()


def close(seen: np.ndarray, expected: np.ndarray, tolerance: float = FLOAT32) -> bool:
    """Equal up to ``tolerance`` per coordinate, with the same number of points."""
    return seen.shape == expected.shape and bool(np.abs(seen - expected).max() < tolerance)


def push(message: str) -> None:
    """An undo step, as the end of any user operation makes one."""
    update()
    bpy.ops.ed.undo_push(message=message)


def evaluated_points(obj: bpy.types.Object) -> np.ndarray:
    """What Blender shows, object space, (n, 3)."""
    update()
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    flat = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
    mesh.vertices.foreach_get("co", flat)
    evaluated.to_mesh_clear()
    return flat.reshape(-1, 3).astype(float)


def base_points(obj: bpy.types.Object) -> np.ndarray:
    """The mesh without modifiers, (n, 3)."""
    flat = np.empty(len(obj.data.vertices) * 3, dtype=np.float32)
    obj.data.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3).astype(float)


def apply_matrix(matrix: Matrix, points: np.ndarray) -> np.ndarray:
    """Points moved by a 4x4 matrix."""
    array = np.array(matrix)
    return points @ array[:3, :3].T + array[:3, 3]


def linked(obj: bpy.types.Object) -> bpy.types.Object:
    """It, in the scene."""
    bpy.context.scene.collection.objects.link(obj)
    return obj


def new_object(
    name: str, points: Iterable[Sequence[float]], faces: Iterable = (), edges: Iterable = ()
) -> bpy.types.Object:
    """A mesh object in the scene."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(list(points), list(edges), list(faces))
    return linked(bpy.data.objects.new(name, mesh))


def new_empty(name: str, location: Sequence[float] = (0.0, 0.0, 0.0)) -> bpy.types.Object:
    """An object without data in the scene."""
    empty = linked(bpy.data.objects.new(name, None))
    empty.location = location
    update()
    return empty


def reopen(path: Path) -> None:
    """Save the scene as a file, and open that."""
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))


@contextmanager
def in_mode(obj: bpy.types.Object, mode: str = "EDIT") -> Iterator[None]:
    """The object is active, in a mode that it leaves in the end."""
    make_active(obj)
    bpy.ops.object.mode_set(mode=mode)
    yield
    bpy.ops.object.mode_set(mode="OBJECT")


def grid_object(name: str = "Plate", cells: int = 10) -> bpy.types.Object:
    """A square of ``cells`` x ``cells`` quads from -1 to 1 in the plane z = 0."""
    line = np.linspace(-1.0, 1.0, cells + 1)
    points = [(x, y, 0.0) for y in line for x in line]
    row = cells + 1
    faces = [
        (j * row + i, j * row + i + 1, (j + 1) * row + i + 1, (j + 1) * row + i)
        for j in range(cells)
        for i in range(cells)
    ]
    obj = new_object(name, points, faces)
    make_active(obj)
    return obj


def make_active(obj: bpy.types.Object) -> None:
    """Select one object."""
    update()
    for other in bpy.context.view_layer.objects:
        other.select_set(other == obj)
    bpy.context.view_layer.objects.active = obj


def add_group(obj: bpy.types.Object, name: str, where) -> np.ndarray:
    """A vertex group of the vertices for which ``where(point)``; their indices."""
    members = [index for index, point in enumerate(base_points(obj)) if where(point)]
    obj.vertex_groups.new(name=name).add(members, 1.0, "REPLACE")
    return np.array(members)


def add_armature(obj: bpy.types.Object, split: float = 0.0) -> bpy.types.Object:
    """Two bones along y that carry the halves of the mesh below and above ``split``."""
    data = bpy.data.armatures.new("Rig")
    armature = linked(bpy.data.objects.new("Rig", data))
    make_active(armature)
    bpy.ops.object.mode_set(mode="EDIT")
    for name, head, tail in (("low", -1.0, split), ("high", split, 1.0)):
        bone = data.edit_bones.new(name)
        bone.head, bone.tail = (0.0, head, 0.0), (0.0, tail, 0.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    add_group(obj, "low", lambda point: point[1] <= split)
    add_group(obj, "high", lambda point: point[1] > split)
    modifier = obj.modifiers.new("Armature", "ARMATURE")
    modifier.object = armature
    make_active(obj)
    return armature


class Rig:
    """A plate, its regions, and its deformer once there is one."""

    def __init__(self, obj: bpy.types.Object) -> None:
        self.name = obj.name
        self.top = add_group(obj, "Top", lambda point: point[1] > 0.75)
        self.base = add_group(obj, "Base", lambda point: point[1] < -0.75)

    @classmethod
    def plate(cls, cells: int = 10) -> Rig:
        return cls(grid_object(cells=cells))

    @property
    def obj(self) -> bpy.types.Object:
        """Looked up each time: undo and load make new Python objects."""
        return bpy.data.objects[self.name]

    @classmethod
    def called(cls, name: str) -> Rig:
        """One that is there already."""
        rig = cls.__new__(cls)
        rig.name = name
        return rig

    @property
    def deformer(self):
        return self.obj.sinew.active

    @property
    def control(self) -> bpy.types.Object:
        return self.deformer.handles[0].control

    def bind(self, method: str = "thin_shell", fixed: bool = True, **keywords) -> Rig:
        """Deformer, handle ``Top``, fixed ``Base``, through the operators."""
        make_active(self.obj)
        bpy.ops.sinew.deformer_add(method=method)
        bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Top", **keywords)
        make_active(self.obj)
        if fixed:
            bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Base")
        return self

    def points(self) -> np.ndarray:
        return evaluated_points(self.obj)

    def rest(self) -> np.ndarray:
        return base_points(self.obj)

    def lift(self, height: float = 1.0) -> None:
        """Move the control along the world's z."""
        move_world(self.control, Matrix.Translation((0.0, 0.0, height)))


def move_world(control: bpy.types.Object, motion: Matrix) -> None:
    """Move an object by a world-space motion, on top of where it is."""
    update()
    control.matrix_world = motion @ control.matrix_world
    update()


def some_motion() -> Matrix:
    """A rigid motion without symmetry."""
    turn = Matrix.Rotation(math.radians(50.0), 4, (0.3, 0.9, -0.2))
    return Matrix.Translation((0.4, -0.2, 0.7)) @ turn


def some_affine() -> Matrix:
    """An affine map with shear and unequal scale."""
    return Matrix(((1.2, 0.3, 0.0, 0.1), (-0.2, 0.8, 0.4, 0.0), (0.1, 0.0, 1.5, 0.5), (0.0, 0.0, 0.0, 1.0)))
