# SPDX-License-Identifier: GPL-3.0-or-later
"""What a task picks by itself from what is selected: sizes, borders, cages. Main thread only."""

from collections.abc import Iterable, Sequence

import numpy as np
from bpy.types import Object
from mathutils import Vector

from ...core.geometry import frames
from ...core.names import numbered
from ...core.tasks import Task, task_for
from ...properties import SinewDeformer
from ..datablocks.movers import armatures_of
from ..targets import targets
from .deformers import add_deformer, put_before_subdivision

_CAGE_FACES = (150, 600)  # the fewest and the most
_PLAIN = 1000  # vertices of a mesh that gets the fewest
_POINTS = (3, 7)  # of a lattice along a side
_THINNEST = 0.1  # of the length of a bone: how deep it lies at least, also where it ends at the skin
_SAMPLE = 2000  # vertices that tell about all
_ALL_OVER = 0.9  # of these


def deformer_for(obj: Object, task: Task, method: str) -> tuple[SinewDeformer, bool]:
    """The active deformer, if it has this method and no control yet, else a new one; whether it is new."""
    active = obj.sinew.active
    held = () if active is None else active.handles
    if active is not None and active.method == method and all(row.kind != "HANDLE" for row in held):
        return active, False
    taken = [other.name for other in obj.sinew.deformers]
    deformer = add_deformer(obj, method, numbered(task.deformer, taken))
    return put_before_subdivision(obj, deformer), True


def width_of_joint(obj: Object, place: np.ndarray) -> float | None:
    """How wide a limb is at a place (3,) of the world where its joint is to be corrected.

    That is twice as wide as the nearest bone lies deep. None if the active deformer corrects no joint, or if
    no bones move the object.
    """
    active = obj.sinew.active
    if active is None or not task_for(active.definition, active.name).stands_behind:
        return None
    ends = np.array(
        [
            armature.matrix_world @ end
            for armature in armatures_of(obj)
            for bone in armature.pose.bones
            if bone.bone.use_deform
            for end in (bone.head, bone.tail)
        ]
    ).reshape(-1, 2, 3)
    if not len(ends):
        return None
    along = ends[:, 1] - ends[:, 0]
    squares = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip(((place - ends[:, 0]) * along).sum(axis=1) / squares, 0.0, 1.0)
    depths = np.linalg.norm(place - ends[:, 0] - share[:, None] * along, axis=1)
    nearest = int(np.argmin(depths))
    return 2.0 * max(depths[nearest], _THINNEST * np.sqrt(squares[nearest]))


def lattice_counts(objects: Sequence[Object]) -> tuple[int, int, int]:
    """The points of a lattice around objects, along the axes of the first: more where it is longer."""
    fewest, most = _POINTS
    frame = objects[0].matrix_world.to_3x3().normalized().to_4x4()
    corners = np.array([frame.transposed() @ corner for obj in objects for corner in box_corners(obj)])
    sides = np.ptp(corners, axis=0)
    cell = max(sides.min() / (fewest - 1), sides.max() / (most - 1))
    if not np.isfinite(cell) or cell <= 0.0:
        return (fewest, fewest, fewest)
    u, v, w = np.clip(np.rint(1.0 + sides / cell), fewest, most)
    return int(u), int(v), int(w)


def cage_faces(objects: Iterable[Object]) -> int:
    """How many faces an automatic cage has: more around more vertices."""
    fewest, most = _CAGE_FACES
    vertices = sum(map(targets.size, objects))
    return int(np.clip(fewest * (max(vertices, 1) / _PLAIN) ** 0.3, fewest, most))


def encloses(cage: Object, obj: Object) -> bool:
    """Whether a mesh is closed, and reaches around an object on all sides."""
    if cage.type != "MESH" or not len(cage.data.polygons) or len(border(cage)):
        return False
    world = frames.inverse(np.array(cage.matrix_world, dtype=np.float64), cage.name)
    inside = frames.transformed(world, np.array(box_corners(obj)))
    around = np.array(cage.bound_box)
    return bool((inside >= around.min(axis=0)).all() and (inside <= around.max(axis=0)).all())


def border(obj: Object) -> np.ndarray:
    """The vertices of the edges of a mesh that one face alone has."""
    mesh = obj.data
    edges = np.empty(len(mesh.loops), dtype=np.int32)
    ends = np.empty(2 * len(mesh.edges), dtype=np.int32)
    mesh.loops.foreach_get("edge_index", edges)
    mesh.edges.foreach_get("vertices", ends)
    alone = np.bincount(edges, minlength=len(mesh.edges)) == 1
    return np.unique(ends.reshape(-1, 2)[alone])


def selected_vertices(obj: Object) -> np.ndarray:
    """The vertices of a mesh that were selected in Edit Mode, outside of it."""
    chosen = np.empty(len(obj.data.vertices), dtype=bool)
    obj.data.vertices.foreach_get("select", chosen)
    return np.flatnonzero(chosen)


def overlap_all_over(obj: Object, names: Iterable[str]) -> bool:
    """Whether nearly all vertices of a mesh are in several of the groups, so that no part would bend."""
    indices = {group.index for name in names if (group := obj.vertex_groups.get(name))}
    vertices = obj.data.vertices
    chosen = [vertices[place] for place in range(0, len(vertices), max(len(vertices) // _SAMPLE, 1))]
    counts = [sum(row.group in indices and row.weight > 0.0 for row in vertex.groups) for vertex in chosen]
    held = [count for count in counts if count]
    return bool(held) and sum(count > 1 for count in held) > _ALL_OVER * len(held)


def box_corners(obj: Object) -> list[Vector]:
    """The corners of its box in the world."""
    return [obj.matrix_world @ Vector(corner) for corner in obj.bound_box]
