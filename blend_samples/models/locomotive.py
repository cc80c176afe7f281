# SPDX-License-Identifier: GPL-3.0-or-later
"""A steam locomotive of thousands of loose parts: plates, rivets, rods, wheels with spokes.

x points ahead, z up, and the rails lie at z = 0. No part is joined to another, so nothing that needs a
surface can move it as a whole.
"""

from collections.abc import Sequence
from itertools import pairwise, product
from math import cos, pi, sin, tau

import bpy
import numpy as np

from ..materials import plain_material
from .objects import add_groups, grid_faces, mesh_object

PARTS = "parts"
PAINT = {
    "Black": (0.018, 0.020, 0.024),
    "Brass": (0.62, 0.30, 0.05),
    "Red": (0.36, 0.020, 0.015),
    "Steel": (0.30, 0.31, 0.33),
}
BOILER, RADIUS = 0.98, 0.36  # height of its axis, and its radius
FRONT, BACK = 1.45, -0.75  # of the boiler
DRIVERS = (-0.62, -0.08, 0.46)  # of the large wheels, along x
BOGIE = (1.02, 1.42)
GAUGE = 0.34
BLACK, BRASS, RED, STEEL = range(4)
AHEAD, LEFT, UP = np.eye(3)
SIDES = (1.0, -1.0)


class Yard:
    """Collects parts: each a mesh of its own, in some groups, of one material."""

    def __init__(self) -> None:
        self.points: list[np.ndarray] = []
        self.faces: list[list[int]] = []
        self.materials: list[int] = []
        self.groups: dict[str, list[int]] = {}
        self.count = 0

    def add(self, points: np.ndarray, faces: list[tuple[int, ...]], material: int, *groups: str) -> None:
        start = self.count
        self.points.append(np.asarray(points, float))
        self.faces += [[start + corner for corner in face] for face in faces]
        self.materials += [material] * len(faces)
        self.count += len(points)
        for group in groups:
            self.groups.setdefault(group, []).extend(range(start, self.count))

    def loft(self, sections: Sequence, material: int, *groups: str) -> None:
        """A closed part through sections (k, m, 3), each a loop that turns right-handed about the way on."""
        points = np.asarray(sections, float)
        count, loop = points.shape[:2]
        faces = [tuple(range(loop - 1, -1, -1)), tuple(range((count - 1) * loop, count * loop))]
        faces += grid_faces(count, loop, around=True).tolist()
        self.add(points.reshape(-1, 3), faces, material, *groups)

    def sweep(
        self, middle: Sequence[float], axis: np.ndarray, along, radii, turns, material: int, *groups: str
    ) -> None:
        """A rectangle about an axis: from one place ``along`` it to another, between radii, through turns."""
        (a, b), (c, d) = along, radii
        corners = ((a, c), (b, c), (b, d), (a, d))
        sections = [[middle + u * axis + r * _outward(axis, turn) for u, r in corners] for turn in turns]
        self.loft(sections, material, *groups)

    def box(self, centre: tuple, half: tuple, material: int, *groups: str, turn: float = 0.0) -> None:
        """A box, turned about x."""
        corners = np.array([[(x, y, z) for y, z in ((-1, -1), (1, -1), (1, 1), (-1, 1))] for x in (-1, 1)])
        spin = np.stack((AHEAD, _outward(AHEAD, turn), _outward(AHEAD, turn + pi / 2)))
        self.loft(corners * half @ spin + centre, material, *groups)

    def tube(self, start, end, radius: float, material: int, *groups: str) -> None:
        start, end = np.asarray(start, float), np.asarray(end, float)
        circle = radius * _circle((end - start) / np.linalg.norm(end - start), 10)
        self.loft([start + circle, end + circle], material, *groups)

    def rivet(self, place: np.ndarray, out: np.ndarray, radius: float, *groups: str) -> None:
        """Half a ball."""
        sides, circle = 6, _circle(out, 6)
        points = place + radius * np.vstack((circle, 0.75 * circle + 0.6 * out, 0.9 * out))
        ring = [(k, (k + 1) % sides) for k in range(sides)]
        faces = [(a, b, b + sides, a + sides) for a, b in ring]
        faces += [(a + sides, b + sides, 2 * sides) for a, b in ring]
        self.add(points, faces, BLACK if "Cab" in groups else BRASS, *groups)


def _outward(axis: np.ndarray, turn: float) -> np.ndarray:
    """A direction across one of the three axes, turned about it from the first of the other two."""
    first = np.eye(3)[np.argmin(np.abs(axis))]
    return cos(turn) * first + sin(turn) * np.cross(axis, first)


def _circle(along: np.ndarray, sides: int) -> np.ndarray:
    """Directions (sides, 3) across another one."""
    first = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    first /= np.linalg.norm(first)
    turns = tau * np.arange(sides)[:, None] / sides
    return np.cos(turns) * first + np.sin(turns) * np.cross(along, first)


def build() -> bpy.types.Object:
    """The object, with groups Drivers, Bogie, Cab and Chimney; its property ``parts`` counts them."""
    yard = Yard()
    _boiler(yard)
    _cab(yard)
    _chassis(yard)
    for x, side in product(DRIVERS, SIDES):
        _wheel(yard, (x, side * GAUGE, 0.30), 0.29, 14, "Drivers")
    for x, side in product(BOGIE, SIDES):
        _wheel(yard, (x, side * GAUGE, 0.18), 0.17, 9, "Bogie")
    for side in SIDES:
        _rods(yard, side)
    paint = [plain_material(name, colour, roughness=0.32, specular=0.6) for name, colour in PAINT.items()]
    points = np.concatenate(yard.points)
    obj = mesh_object("Locomotive", points, yard.faces, slots=yard.materials, materials=paint)
    add_groups(obj, yard.groups)
    obj[PARTS] = len(yard.points)
    return obj


def _boiler(yard: Yard) -> None:
    """Rings of curved plates with a seam of rivets at each end; bands of brass; dome and chimney."""
    rings, plates = 11, 14
    length = (FRONT - BACK) / rings
    middle = BOILER * UP

    def curved(x: tuple[float, float], angle: float, width: float, radius: float, material: int) -> None:
        turns = angle + width * (np.arange(4) / 3 - 0.5)
        yard.sweep(middle, AHEAD, x, (radius - 0.012, radius), turns, material)

    for ring in range(rings):
        x = BACK + ring * length
        for plate in range(plates):
            angle = tau * (plate + 0.5 * (ring % 2)) / plates
            curved((x + 0.004, x + length - 0.004), angle, 0.97 * tau / plates, RADIUS, BLACK)
        for seam, k in product((0.018, length - 0.018), range(56)):
            out = _outward(AHEAD, tau * k / 56)
            yard.rivet((x + seam) * AHEAD + middle + (RADIUS + 0.006) * out, out, 0.011)
        for k in range(28 if ring % 3 == 0 else 0):
            curved((x - 0.016, x + 0.016), tau * k / 28, 0.98 * tau / 28, RADIUS + 0.012, BRASS)
    for k, radius in product(range(40), (0.33, 0.24, 0.15)):  # the door of the smoke box
        out = _outward(AHEAD, tau * k / 40)
        yard.rivet((FRONT + 0.035) * AHEAD + middle + radius * out, AHEAD, 0.010)
    for sector in range(10):
        turns = tau / 10 * (sector + 0.98 * (np.arange(4) / 3 - 0.5))
        spokes = [(0.02, tau * sector / 10), *((0.35, turn) for turn in turns)]
        flat = np.array([middle + r * _outward(AHEAD, turn) for r, turn in spokes])
        yard.loft([flat + x * AHEAD for x in (FRONT, FRONT + 0.03)], BLACK)
    top = BOILER + RADIUS
    for level in range(9):  # the chimney
        radius, height = 0.105 + 0.05 * max(0.0, level / 8 - 0.6) * 2.5, top + 0.045 * level
        _ring(yard, (1.12, 0.0, height - 0.02), radius, 0.040, BLACK, "Chimney")
        for k in range(18):
            out = _outward(UP, tau * k / 18)
            yard.rivet((1.12, 0.0, height) + (radius + 0.002) * out, out, 0.008, "Chimney")
    for level in range(5):
        _ring(yard, (0.25, 0.0, top - 0.03 + 0.05 * level), 0.15 * cos(0.33 * level), 0.045, BRASS)
    yard.rivet(np.array((0.25, 0.0, top + 0.20)), UP, 0.06)
    step = (FRONT - BACK - 0.16) / 15
    for side, k in product(SIDES, range(16)):  # hand rails
        rail = np.array([BACK + 0.08 + k * step, side * (RADIUS + 0.05), BOILER + 0.12])
        yard.tube(rail - 0.07 * side * LEFT, rail, 0.008, STEEL)
        if k < 15:
            yard.tube(rail, rail + (step - 0.004) * AHEAD, 0.012, STEEL)


def _ring(yard: Yard, foot: tuple, radius: float, height: float, material: int, *groups: str) -> None:
    for k in range(12):
        turns = [tau * (k / 12 + share) for share in (0.0, 0.04, 0.08)]
        yard.sweep(foot, UP, (0.0, height), (radius - 0.015, radius), turns, material, *groups)


def _cab(yard: Yard) -> None:
    """Walls of plates, a curved roof of slats, rivets along all edges."""
    for side, i, j in product(SIDES, range(4), range(5)):
        if 1 <= i <= 2 and j == 3:
            continue  # the window
        centre = (-1.36 + 0.16 * i, side * 0.40, 0.62 + 0.17 * j)
        yard.box(centre, (0.076, 0.012, 0.081), RED, "Cab")
        for x, z in product((-0.06, 0.0, 0.06), (-0.066, 0.066)):
            yard.rivet(np.array(centre) + (x, side * 0.014, z), side * LEFT, 0.009, "Cab")
    for k in range(15):
        angle = pi * (k + 0.5) / 15
        centre = (-1.12, 0.44 * cos(angle), 1.42 + 0.14 * sin(angle))
        yard.box(centre, (0.36, 0.043, 0.012), BLACK, "Cab", turn=angle - pi / 2)
        for x in np.linspace(-1.44, -0.80, 12):
            yard.rivet(np.array([x, centre[1], centre[2] + 0.014]), UP, 0.008, "Cab")


def _chassis(yard: Yard) -> None:
    """Beams, running boards of planks, buffers, and a fender of slats."""
    for side in SIDES:
        for x in -1.42 + 0.124 * np.arange(24):
            yard.box((x, side * 0.46, 0.60), (0.058, 0.075, 0.012), STEEL)
            yard.box((x, side * 0.24, 0.46), (0.058, 0.02, 0.06), RED)
            for dx in (-0.04, 0.0, 0.04):
                yard.rivet(np.array([x + dx, side * 0.52, 0.613]), UP, 0.007)
                yard.rivet(np.array([x + dx, side * 0.262, 0.46]), side * LEFT, 0.007)
        yard.tube((1.50, side * 0.28, 0.50), (1.66, side * 0.28, 0.50), 0.03, STEEL)
        yard.tube((1.66, side * 0.28, 0.50), (1.68, side * 0.28, 0.50), 0.075, BLACK)
    for y in 0.42 * (np.arange(13) - 6) / 6:
        yard.tube((1.52, y, 0.44), (1.84 - 0.5 * abs(y), 0.75 * y, 0.07), 0.013, RED)
    yard.box((1.50, 0.0, 0.48), (0.02, 0.46, 0.06), RED)


def _wheel(yard: Yard, centre: tuple, radius: float, spokes: int, group: str) -> None:
    """A tyre and a rim of segments, spokes, a hub, and bolts on all of them."""
    middle = np.array(centre)
    outside = np.sign(middle[1]) * LEFT
    segments = 24
    for k in range(segments):
        turns = tau / segments * (k + 0.97 * np.arange(3) / 2)
        for inner, outer, width, material in ((0.90, 1.0, 0.05, STEEL), (0.78, 0.895, 0.035, RED)):
            radii, across = (radius * inner, radius * outer), (-width / 2, width / 2)
            yard.sweep(middle, -LEFT, across, radii, turns, material, group)
        bolt = _outward(-LEFT, tau * k / segments + 0.1)
        yard.rivet(middle + radius * 0.84 * bolt + 0.018 * outside, outside, 0.009, group)
    for k in range(spokes):
        out = _outward(-LEFT, tau * k / spokes)
        yard.tube(middle + 0.2 * radius * out, middle + 0.78 * radius * out, 0.012, RED, group)
    yard.tube(middle - 0.03 * LEFT, middle + 0.03 * LEFT, 0.2 * radius, BLACK, group)
    yard.tube(middle, middle + 0.05 * outside, 0.08 * radius, BRASS, group)


def _rods(yard: Yard, side: float) -> None:
    """The rods between the large wheels go with these."""
    y = side * (GAUGE + 0.07)
    for a, b in pairwise(DRIVERS):
        yard.box(((a + b) / 2, y, 0.22), ((b - a) / 2, 0.012, 0.022), STEEL, "Drivers")
    for x in DRIVERS:
        yard.tube((x, y - side * 0.03, 0.22), (x, y + side * 0.03, 0.22), 0.034, BRASS, "Drivers")
    yard.box((0.88, y, 0.36), (0.16, 0.07, 0.09), BLACK)
