# SPDX-License-Identifier: GPL-3.0-or-later
"""A ship of meshes, curves, text, hair and Blender's own lattice, all moved by one lattice or one twist."""

from collections.abc import Sequence
from math import pi

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Vector

from .. import posing
from ..lineup import POSE_FRAME, there_and_back
from ..materials import plain_material
from ..models.objects import grid_faces, mesh_object
from ..posing import Move, add_lines, add_object, make_active
from ..studio import Shot, empty_scene, open_at

SPACING, HEADING = 2.8, -28.0
SHOT = Shot((0.0, 0.0, 0.98), 8.2, 9.0, 26.0, picture=(1680, 560), front=-1.6)
LENGTH = 0.95  # half of the hull's, along x
MAST, YARD, FOOT = 1.86, 1.66, 0.80  # heights: top of the mast, upper and lower edge of the sail
SAIL_WIDTH, SAIL_TURN = 1.16, -38.0  # the turn of the yard in degrees about z
SIDES = (1.0, -1.0)
STRAND = 0.0025  # radius of a hair
WIND = 0.30  # how far the middle of the sail is blown out
PAINT = {
    "Wood": (0.32, 0.15, 0.055),
    "Dark Wood": (0.10, 0.042, 0.016),
    "Rope": (0.55, 0.44, 0.28),
    "Red": (0.36, 0.020, 0.015),
    "Linen": (0.80, 0.74, 0.62),
    "Gold": (0.62, 0.30, 0.05),
    "Hair": (0.02, 0.015, 0.012),
}
LABELS = ("Rest", "One Lattice", "One Twist")


def make() -> bpy.types.Scene:
    scene = empty_scene()
    places = posing.places(len(LABELS), SPACING)
    ships = [build(label, x) for label, x in zip(LABELS, places)]
    pose_by_lattice(ships[1])
    pose_by_twist(ships[2])
    for obj in (*ships[1], *ships[2]):
        posing.check_posed(obj)
    SHOT.set_up(scene, zip(LABELS, places))
    open_at(scene, POSE_FRAME, ships[1][0])
    return scene


def build(name: str, x: float) -> list[bpy.types.Object]:
    ship = parts(name)
    bpy.context.view_layer.update()
    stand = Matrix.Translation((x, 0.0, 0.0)) @ Matrix.Rotation(np.radians(HEADING), 4, "Z")
    for obj in ship:
        obj.matrix_world = stand @ obj.matrix_world
    return ship


def pose_by_lattice(ship: list[bpy.types.Object]) -> None:
    """The ship rears: it bends along its length, and all above leans back."""
    lattice = posing.add_lattice(ship[0], (5, 3, 4), *ship[1:])
    x, y, z = posing.lattice_points(lattice).T
    height = z + 0.5
    moved = (x * (1.0 - 0.25 * height) - 0.30 * height**2, y, z + 0.30 * (x + 0.2) ** 2 - 0.04)
    posing.add_pose(lattice, "Rear", np.column_stack(moved), {1: 0.0, POSE_FRAME: 1.0, 60: 1.0, 96: 0.0})


def pose_by_twist(ship: list[bpy.types.Object]) -> None:
    """One tool on the mast: the higher, the farther it turns."""
    bpy.context.view_layer.update()
    middle = ship[0].matrix_world.translation.copy()
    middle.z = 1.0
    control = ""
    for obj in ship:
        row = posing.operate(obj, "tool_add", tool="twist", location=middle, control=control).controls[-1]
        row.inner, row.outer, row.width = -1.2, 0.9, 3.0
        control = row.object.name
    turn = Move(turn=(0.0, 0.0, 100.0), pivot=(0.0, 0.0, 1.0))
    posing.animate(row.object, there_and_back((POSE_FRAME, turn)), ship[0])


def parts(name: str) -> list[bpy.types.Object]:
    """A ship in the scene's collection: its objects, but for the sail and the letter in its lattice."""
    lattice = sail_lattice(name)
    sail(name, lattice)
    emblem(name, lattice)
    letters = text(f"{name} Name", "SINEW", 0.14)  # on the planks, under the shields
    letters.location = 0.0, -0.318, 0.215
    letters.rotation_euler.x = np.radians(118.0)
    return [hull(name), shields(name), *lines(name), letters, tail(name), lattice]


def breadth(s: np.ndarray) -> np.ndarray:
    """Half the width of the ship at the rim; ``s`` is -1 at the stern and 1 at the bow."""
    return 0.36 * np.maximum(1.0 - s**4, 0.0) ** 0.8


def rim_height(s: np.ndarray) -> np.ndarray:
    return 0.40 + 0.30 * s**4


def keel_height(s: np.ndarray) -> np.ndarray:
    return 0.06 + 0.50 * s**6


def hull(name: str) -> bpy.types.Object:
    """Planks from rim to rim, and a deck."""
    stations, girth = np.linspace(-0.995, 0.995, 61), np.linspace(-1.0, 1.0, 19)
    s, t = (grid.ravel() for grid in np.meshgrid(stations, girth, indexing="ij"))
    y = breadth(s) * np.sign(t) * np.sin(np.abs(t) * pi / 2) ** 0.8
    z = keel_height(s) + (rim_height(s) - keel_height(s)) * (1.0 - np.cos(np.abs(t) * pi / 2)) ** 0.9
    planks = np.stack((LENGTH * s, y, z), axis=1)
    across = np.stack((LENGTH * s, 0.72 * np.abs(breadth(s)) * t, np.full_like(s, 0.27)), axis=1)
    inside = np.repeat(np.abs(stations) < 0.82, len(girth))
    across = across[inside]
    faces = quads(len(stations), len(girth))
    deck = quads(int(inside.sum()) // len(girth), len(girth)) + len(planks)
    points = np.concatenate((planks, across))
    obj = mesh_object(f"{name} Hull", points, np.concatenate((faces, deck)), smooth=True)
    coat(obj.data, "Wood")
    thickness = obj.modifiers.new("Solidify", "SOLIDIFY")
    thickness.thickness, thickness.offset = 0.024, 0.0
    return obj


def quads(rows: int, columns: int) -> np.ndarray:
    """The faces (m, 4) of a grid of points, row after row, seen from its other side."""
    return grid_faces(rows, columns)[:, [0, 3, 2, 1]]


def coat(data: bpy.types.ID, *paints: str) -> None:
    for paint in paints:
        data.materials.append(plain_material(paint, PAINT[paint], roughness=0.5))


def shields(name: str) -> bpy.types.Object:
    """Round shields along both rims, each with a boss: loose parts of one mesh."""
    shapes = bmesh.new()
    for number, x in enumerate(np.linspace(-0.56, 0.56, 6)):
        s = np.array(x / LENGTH)
        for side in (1.0, -1.0):
            place = Matrix.Translation((x, side * (float(breadth(s)) + 0.03), float(rim_height(s)) - 0.01))
            for radius, depth, slot in ((0.108, 0.022, number % 2), (0.034, 0.042, 2)):
                flat = place @ Matrix.Diagonal((radius, depth, radius, 1.0))
                made = bmesh.ops.create_uvsphere(
                    shapes, u_segments=32, v_segments=16, radius=1.0, matrix=flat
                )
                for face in {face for vertex in made["verts"] for face in vertex.link_faces}:
                    face.material_index, face.smooth = slot, True
    mesh = bpy.data.meshes.new(f"{name} Shields")
    shapes.to_mesh(mesh)
    shapes.free()
    coat(mesh, "Red", "Linen", "Gold")
    return add_object(mesh.name, mesh)


def turned(x: float, y: float, z: float) -> Vector:
    """A place on the sail, which is turned about the mast."""
    return Matrix.Rotation(np.radians(SAIL_TURN), 3, "Z") @ Vector((x, y, z))


def between(start: Sequence[float], end: Sequence[float]) -> np.ndarray:
    return np.linspace(tuple(start), tuple(end), 24)


def lines(name: str) -> list[bpy.types.Object]:
    """The keel from the curl of the stern to that of the bow, rims, mast and yard, and ropes."""
    s = np.linspace(-1.0, 1.0, 60)
    bottom = np.stack((LENGTH * s, 0.0 * s, keel_height(s) - 0.01), axis=1)
    turn, radius = np.linspace(-0.1 * pi, 1.75 * pi, 40), np.linspace(0.26, 0.05, 40)
    curl = np.stack((radius * np.cos(turn), 0.0 * turn, radius * np.sin(turn)), axis=1)
    bow = curl - curl[0] + bottom[-1] + (0.03, 0.0, 0.05)
    keel = np.concatenate((bow[::-1] * (-1.0, 1.0, 1.0), bottom, bow))
    t = 0.995 * s
    rims = [np.stack((LENGTH * t, side * breadth(t), rim_height(t)), axis=1) for side in SIDES]
    yard = between(*(turned(0.0, 0.5 * SAIL_WIDTH * side, YARD) for side in (1.08, -1.0)))
    ends = [(0.93 * LENGTH * side, 0.0, 0.62) for side in SIDES]
    ends += [(x, side * 0.34, 0.40) for x in (-0.12, 0.0, 0.12) for side in SIDES]
    corners = {side: turned(0.0, 0.5 * SAIL_WIDTH * side, FOOT) for side in SIDES}
    sheets = [between(corner, (-0.55, 0.28 * side, 0.42)) for side, corner in corners.items()]
    return [
        tubes(f"{name} Keel", 0.034, "Dark Wood", [keel]),
        tubes(f"{name} Rim", 0.020, "Dark Wood", rims),
        tubes(f"{name} Spars", 0.026, "Dark Wood", [between((0.0, 0.0, 0.1), (0.0, 0.0, MAST)), yard]),
        tubes(f"{name} Ropes", 0.0075, "Rope", [between((0, 0, MAST - 0.02), end) for end in ends] + sheets),
    ]


def tubes(name: str, radius: float, paint: str, lines: list[np.ndarray]) -> bpy.types.Object:
    obj = add_lines(name, lines, bevel=radius)
    obj.data.bevel_resolution, obj.data.use_fill_caps = 3, True
    coat(obj.data, paint)
    return obj


def sail_lattice(name: str) -> bpy.types.Object:
    """Blender's own lattice around the sail; its shape key blows the sail out."""
    data = bpy.data.lattices.new(f"{name} Sail Lattice")
    data.points_u, data.points_v, data.points_w = 2, 5, 6
    obj = add_object(data.name, data)
    obj.scale = 0.5, SAIL_WIDTH / 4.0, (YARD - FOOT) / 5.0  # Blender puts the points 1 apart
    obj.shape_key_add(name="Flat")
    wind = obj.shape_key_add(name="Wind")
    wind.value = 1.0
    for point in wind.data:
        across, up = point.co.y / 2.0, point.co.z / 2.5  # -1 to 1
        point.co.x += WIND / 0.5 * (1.0 - across**2) * (1.0 - up) * (1.6 + up)
    place_at_sail(obj)
    return obj


def place_at_sail(obj: bpy.types.Object) -> None:
    obj.location = 0.0, 0.0, 0.5 * (YARD + FOOT)
    obj.rotation_euler.z = np.radians(SAIL_TURN)


def sail(name: str, lattice: bpy.types.Object) -> bpy.types.Object:
    """A flat cloth in stripes, which the lattice blows out."""
    rows, columns = 36, 43
    y, z = np.meshgrid(np.linspace(-0.5, 0.5, columns), np.linspace(-0.5, 0.5, rows))
    flat = np.stack((0.0 * y, SAIL_WIDTH * y, (YARD - FOOT) * z), axis=-1).reshape(-1, 3)
    obj = mesh_object(f"{name} Sail", flat, quads(rows, columns), smooth=True)
    coat(obj.data, "Linen", "Red")
    stripes = np.arange(len(obj.data.polygons)) % (columns - 1) // 6 % 2
    obj.data.polygons.foreach_set("material_index", stripes)
    place_at_sail(obj)
    follow(obj, lattice)
    return obj


def follow(obj: bpy.types.Object, lattice: bpy.types.Object) -> None:
    bpy.context.view_layer.update()
    obj.parent, obj.matrix_parent_inverse = lattice, lattice.matrix_world.inverted()
    obj.modifiers.new("Lattice", "LATTICE").object = lattice


def emblem(name: str, lattice: bpy.types.Object) -> bpy.types.Object:
    """A letter on the sail, which the same lattice blows out."""
    obj = text(f"{name} Emblem", "S", 0.62)
    place_at_sail(obj)
    front = Matrix.Rotation(np.radians(SAIL_TURN), 4, "Z") @ Matrix.Rotation(pi / 2, 4, "Z")
    obj.rotation_euler = (front @ Matrix.Rotation(pi / 2, 4, "X")).to_euler()
    obj.location += turned(0.012, 0.0, 0.0)
    follow(obj, lattice)
    return obj


def text(name: str, words: str, size: float) -> bpy.types.Object:
    data = bpy.data.curves.new(name, "FONT")
    data.body, data.size, data.extrude = words, size, 0.006
    data.align_x, data.align_y, data.resolution_u = "CENTER", "CENTER", 8
    coat(data, "Gold")
    return add_object(name, data)


def tail(name: str) -> bpy.types.Object:
    """A horse's tail at the masthead: hair curves."""
    chance = np.random.default_rng(7)
    way = np.linspace(0.0, 1.0, 14)
    middle = np.stack((-0.40 * way, 0.0 * way, 0.10 * way - 0.26 * way**2 + MAST), axis=1)
    spread = [chance.normal(0.0, 0.05, 3) * (1.0, 1.0, 0.6) for _ in range(220)]
    make_active(add_lines(f"{name} Tail", [middle + np.outer(way**0.8, aside) for aside in spread]))
    bpy.ops.object.convert(target="CURVES")
    hair = bpy.context.object
    hair.name = f"{name} Tail"
    if "radius" not in hair.data.attributes:
        hair.data.attributes.new("radius", "FLOAT", "POINT")
    hair.data.attributes["radius"].data.foreach_set("value", [STRAND] * len(hair.data.points))
    hair.data.materials.clear()
    coat(hair.data, "Hair")
    return hair
