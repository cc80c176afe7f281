# SPDX-License-Identifier: GPL-3.0-or-later
"""From arrays to Blender mesh objects."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import bmesh
import bpy
import numpy as np
from mathutils.kdtree import KDTree

from ..materials import eye_material
from ..posing import add_object, stored
from .sculpt import ball, grid_faces, neighbour_mean, weld_lists


@dataclass
class Sculpture:
    """A mesh as arrays, with what its materials and handles need."""

    points: np.ndarray  # (n, 3)
    quads: np.ndarray  # (m, 4)
    colours: np.ndarray  # (n, 3) linear RGB
    materials: np.ndarray | None = None  # (m,) material slot of each face
    attributes: dict[str, np.ndarray] = field(default_factory=dict)  # (n,) floats, read by the materials
    regions: dict[str, np.ndarray] = field(default_factory=dict)  # vertex group name -> vertex indices


@dataclass(frozen=True)
class Eyes:
    """A pair of balls. Angles are radians from the line of sight."""

    places: np.ndarray  # (2, 3)
    radius: float
    sight: Sequence[float]  # of the left one
    iris: Sequence[float]  # its colour
    pupil: float  # how far it reaches
    edge: float  # where the white begins

    def frames(self) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Of each eye its place, its line of sight, and axes (3, 3) as columns of which this is the first."""
        for place, side in zip(self.places, (1, -1)):
            gaze = np.array(self.sight) * (1, side, 1) / np.linalg.norm(self.sight)
            across = np.cross((0, 0, 1), gaze) / np.linalg.norm(np.cross((0, 0, 1), gaze))
            yield place, gaze, np.stack((gaze, across, np.cross(gaze, across)), 1)

    def distance(self, points: np.ndarray) -> np.ndarray:
        """How far points (n, 3) are from the middle of the nearer eye."""
        return np.min([np.linalg.norm(points - place, axis=1) for place in self.places], axis=0)

    def material(self) -> bpy.types.Material:
        return eye_material("Eye", self.iris, self.pupil, self.edge)

    def put_in(self, points: np.ndarray, quads: np.ndarray, colours: np.ndarray, cuts: int) -> Sculpture:
        """The mesh of a skin with these eyes, in the second material, and with the attribute ``gaze``. Their
        colours are for the viewport; the material has them sharp."""
        parts, angles = [(points, quads)], [np.full(len(points), np.pi)]
        for place, gaze, _axes in self.frames():
            parts.append(ball(place, self.radius, cuts))
            angles.append(np.arccos(np.clip((parts[-1][0] - place) @ gaze / self.radius, -1, 1)))
        everywhere, faces = weld_lists(parts)
        angle = np.concatenate(angles)
        white = np.tile((0.80, 0.77, 0.72), (len(angle) - len(points), 1))
        white[angle[len(points) :] < self.edge] = self.iris
        white[angle[len(points) :] < self.pupil] = 0.004
        slots = np.arange(len(faces)) >= len(quads)
        return Sculpture(everywhere, faces, np.vstack((colours, white)), slots, {"gaze": angle})


def layered(
    colours: np.ndarray, layers: Iterable[tuple[np.ndarray, Sequence[float] | np.ndarray]]
) -> np.ndarray:
    """Colours (n, 3) under layers of paint: how much covers each vertex, and the colour."""
    for weight, colour in layers:
        colours = colours + np.asarray(weight)[:, None] * (np.asarray(colour) - colours)
    return colours


def hollows(points: np.ndarray, quads: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """How far the skin lies below its surroundings (n,): positive in hollows, negative on ridges."""
    return soften(np.einsum("ij,ij->i", neighbour_mean(points, quads) - points, normals), quads, 1)


def to_object(
    name: str, sculpture: Sculpture, materials: Iterable[bpy.types.Material] = ()
) -> bpy.types.Object:
    """A smooth-shaded object in the scene's collection, with colours, attributes and vertex groups."""
    points, slots = sculpture.points, sculpture.materials
    obj = mesh_object(name, points, sculpture.quads, smooth=True, slots=slots, materials=materials)
    add_colours(obj.data, sculpture.colours)
    add_fields(obj.data, sculpture.attributes)
    add_groups(obj, sculpture.regions)
    return obj


def add_colours(mesh: bpy.types.Mesh, colours: np.ndarray) -> None:
    """Store linear RGB (n, 3) of the vertices as ``Colour``."""
    rgba = np.column_stack((colours, np.ones(len(colours)))).astype(np.float32)
    mesh.color_attributes.new("Colour", "FLOAT_COLOR", "POINT").data.foreach_set("color", rgba.ravel())


def add_fields(mesh: bpy.types.Mesh, fields: Mapping[str, np.ndarray]) -> None:
    """Store numbers (n,) of the vertices for materials, and the rest positions, which keep textures in place.
    Vertices beyond the end of a field get -1."""
    for name, values in fields.items():
        padded = np.full(len(mesh.vertices), -1.0, np.float32)
        padded[: len(values)] = values
        mesh.attributes.new(name, "FLOAT", "POINT").data.foreach_set("value", padded)
    rest = stored(mesh.vertices, "co").ravel()
    mesh.attributes.new("rest", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", rest)


def mesh_object(
    name: str,
    points: np.ndarray | Sequence,
    faces: np.ndarray | Sequence,
    parent: bpy.types.Object | None = None,
    smooth: bool = False,
    slots: Sequence[int] | None = None,
    materials: Iterable[bpy.types.Material] = (),
) -> bpy.types.Object:
    """An object in the scene's collection; ``slots`` are the material slots of the faces."""
    mesh = bpy.data.meshes.new(name)
    points, faces = (part.tolist() if isinstance(part, np.ndarray) else part for part in (points, faces))
    mesh.from_pydata(points, [], faces)
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(faces))
    if slots is not None:
        mesh.polygons.foreach_set("material_index", np.asarray(slots, np.int32))
    for material in materials:
        mesh.materials.append(material)
    return add_object(name, mesh, parent)


def keep_vertices(mesh: bpy.types.Mesh, kept: np.ndarray) -> None:
    """Delete the vertices that are not to stay, of bool (n,)."""
    edit = bmesh.new()
    edit.from_mesh(mesh)
    edit.verts.ensure_lookup_table()
    lost = [edit.verts[index] for index in np.flatnonzero(~kept)]
    bmesh.ops.delete(edit, geom=lost, context="VERTS")
    edit.to_mesh(mesh)
    edit.free()


def add_groups(obj: bpy.types.Object, regions: dict[str, np.ndarray]) -> None:
    """Vertex groups of full weight: their vertices, by name."""
    for group, indices in regions.items():
        obj.vertex_groups.new(name=group).add(np.asarray(indices).tolist(), 1.0, "REPLACE")


def disc(cells: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A grid bent to a disc of radius 1: points (n, 2), quads (m, 4), and the vertices of its rim."""
    u, v = square(cells).T
    points = np.stack((u * np.sqrt(1 - v * v / 2), v * np.sqrt(1 - u * u / 2)), 1)
    number = np.arange(len(points)).reshape(cells + 1, cells + 1)
    rim = np.concatenate((number[:-1, 0], number[-1, :-1], number[:0:-1, -1], number[0, :0:-1]))
    return points, grid_faces(cells + 1, cells + 1)[:, ::-1], rim


def square(cells: int) -> np.ndarray:
    """The points (n, 2) of the grid that ``disc`` bends, from -1 to 1."""
    line = np.linspace(-1, 1, cells + 1)
    return np.stack([side.ravel() for side in np.meshgrid(line, line, indexing="ij")], 1)


def soften(values: np.ndarray, quads: np.ndarray, rounds: int) -> np.ndarray:
    """Values at vertices (n, ...), averaged with their neighbours a few times."""
    for _ in range(rounds):
        values = 0.5 * (values + neighbour_mean(values, quads))
    return values


def lobes(points: np.ndarray, spacing: float, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cells around scattered points: offset (n, 3) from it, distance (n,) to the border, cell (n,)."""
    centres = points[scatter(points, spacing, seed)]
    tree = KDTree(len(centres))
    for i, centre in enumerate(centres):
        tree.insert(centre, i)
    tree.balance()
    found = [tree.find_n(point, 2) for point in points]
    gap = np.array([second[2] - first[2] for first, second in found])
    cell = np.array([first[1] for first, _ in found])
    return points - centres[cell], gap, cell


def scatter(points: np.ndarray, spacing: float, seed: int) -> np.ndarray:
    """Indices of points at least ``spacing`` apart, chosen at random but the same each time."""
    tree = KDTree(len(points))
    for i, point in enumerate(points):
        tree.insert(point, i)
    tree.balance()
    free = np.ones(len(points), bool)
    kept = []
    for i in np.random.default_rng(seed).permutation(len(points)):
        if free[i]:
            kept.append(int(i))
            free[[near[1] for near in tree.find_range(points[i], spacing)]] = False
    return np.array(kept)
