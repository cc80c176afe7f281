# SPDX-License-Identifier: GPL-3.0-or-later
"""A steam locomotive of thousands of loose parts: plates, rivets, rods, wheels with spokes.

x points ahead, z up, and the rails lie at z = 0. No part is joined to another, so nothing that needs a
surface can move it as a whole.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
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


class Yard:
    """Collects parts: each a mesh of its own, in some groups, of one material."""

    def __init__(self) -> None:
        self.points: list[np.ndarray] = []
        self.faces: list[list[int]] = []
        self.materials: list[int] = []
        self.groups: dict[str, list[int]] = {}
        self.parts = self.count = 0

    def add(self, points: np.ndarray, faces: list[tuple[int, ...]], material: int, *groups: str) -> None:
        start = self.count
        self.points.append(np.asarray(points, float))
        self.faces += [[start + corner for corner in face] for face in faces]
        self.materials += [material] * len(faces)
        self.count += len(points)
        self.parts += 1
        for group in groups:
            self.groups.setdefault(group, []).extend(range(start, self.count))

    def loft(self, sections: Sequence, material: int, *groups: str) -> None:
        """A closed part through sections (k, m, 3), each a loop that turns right-handed about the way on."""
        points = np.asarray(sections, float)
        count, loop = points.shape[:2]
        faces = [tuple(range(loop - 1, -1, -1)), tuple(range((count - 1) * loop, count * loop))]
        faces += grid_faces(count, loop, around=True).tolist()
        self.add(points.reshape(-1, 3), faces, material, *groups)


def build() -> bpy.types.Object:
    """The object, with groups Drivers, Bogie, Cab and Chimney; its property ``parts`` counts them."""
    yard = Yard()
    _boiler(yard)
    _cab(yard)
    _chassis(yard)
    for x in DRIVERS:
        for side in (1.0, -1.0):
            _wheel(yard, (x, side * GAUGE, 0.30), 0.29, 14, "Drivers")
    for x in BOGIE:
        for side in (1.0, -1.0):
            _wheel(yard, (x, side * GAUGE, 0.18), 0.17, 9, "Bogie")
    for side in (1.0, -1.0):
        _rods(yard, side)
    paint = [plain_material(name, colour, roughness=0.32, specular=0.6) for name, colour in PAINT.items()]
    points = np.concatenate(yard.points)
    obj = mesh_object("Locomotive", points, yard.faces, slots=yard.materials, materials=paint)
    add_groups(obj, yard.groups)
    obj[PARTS] = yard.parts
    return obj


BLACK, BRASS, RED, STEEL = range(4)


def _boiler(yard: Yard) -> None:
    """Rings of curved plates with a seam of rivets at each end; bands of brass; dome and chimney."""
    rings, plates = 11, 14
    length = (FRONT - BACK) / rings
    for ring in range(rings):
        x = BACK + ring * length
        for plate in range(plates):
            angle = tau * (plate + 0.5 * (ring % 2)) / plates
            _curved(yard, (x + 0.004, x + length - 0.004), angle, 0.97 * tau / plates, RADIUS, BLACK)
        for seam in (0.018, length - 0.018):
            for k in range(56):
                _rivet(yard, _around(x + seam, tau * k / 56, RADIUS + 0.006), _outward(tau * k / 56), 0.011)
        if ring % 3 == 0:
            for k in range(28):
                _curved(yard, (x - 0.016, x + 0.016), tau * k / 28, 0.98 * tau / 28, RADIUS + 0.012, BRASS)
    for k in range(40):  # the door of the smoke box
        for radius in (0.33, 0.24, 0.15):
            place = _around(FRONT + 0.035, tau * k / 40, radius)
            _rivet(yard, place, np.array([1.0, 0.0, 0.0]), 0.010)
    for sector in range(10):
        _sector(yard, FRONT, FRONT + 0.03, tau * sector / 10, 0.98 * tau / 10, 0.35)
    for level in range(9):  # the chimney
        radius = 0.105 + 0.05 * max(0.0, level / 8 - 0.6) * 2.5
        _ring(yard, (1.12, 0.0, BOILER + RADIUS - 0.02 + 0.045 * level), radius, 0.040, BLACK, "Chimney")
        for k in range(18):
            out = np.array([cos(tau * k / 18), sin(tau * k / 18), 0.0])
            place = np.array([1.12, 0.0, BOILER + RADIUS + 0.045 * level]) + (radius + 0.002) * out
            _rivet(yard, place, out, 0.008, "Chimney")
    for level in range(5):
        height = BOILER + RADIUS - 0.03 + 0.05 * level
        _ring(yard, (0.25, 0.0, height), 0.15 * cos(0.33 * level), 0.045, BRASS)
    _ball(yard, (0.25, 0.0, BOILER + RADIUS + 0.20), 0.06, BRASS)
    for side in (1.0, -1.0):  # hand rails
        for k in range(16):
            x = BACK + 0.08 + k * (FRONT - BACK - 0.16) / 15
            rail = np.array([x, side * (RADIUS + 0.05), BOILER + 0.12])
            _tube(yard, rail - (0.0, side * 0.07, 0.0), rail, 0.008, STEEL)
            if k < 15:
                _tube(yard, rail, rail + ((FRONT - BACK - 0.16) / 15 - 0.004, 0.0, 0.0), 0.012, STEEL)


def _cab(yard: Yard) -> None:
    """Walls of plates, a curved roof of slats, rivets along all edges."""
    for side in (1.0, -1.0):
        for i in range(4):
            for j in range(5):
                if 1 <= i <= 2 and j == 3:
                    continue  # the window
                centre = (-1.36 + 0.16 * i, side * 0.40, 0.62 + 0.17 * j)
                _box(yard, centre, (0.076, 0.012, 0.081), RED, "Cab")
                for dx in (-0.06, 0.0, 0.06):
                    for dz in (-0.066, 0.066):
                        place = np.array(centre) + (dx, side * 0.014, dz)
                        _rivet(yard, place, np.array([0.0, side, 0.0]), 0.009, "Cab")
    for k in range(15):
        angle = pi * (k + 0.5) / 15
        centre = (-1.12, 0.44 * cos(angle), 1.42 + 0.14 * sin(angle))
        _box(yard, centre, (0.36, 0.043, 0.012), BLACK, "Cab", turn=angle - pi / 2)
        for x in np.linspace(-1.44, -0.80, 12):
            _rivet(yard, np.array([x, centre[1], centre[2] + 0.014]), np.array([0.0, 0.0, 1.0]), 0.008, "Cab")


def _chassis(yard: Yard) -> None:
    """Beams, running boards of planks, buffers, and a fender of slats."""
    for side in (1.0, -1.0):
        for k in range(24):
            x = -1.42 + k * 0.124
            _box(yard, (x, side * 0.46, 0.60), (0.058, 0.075, 0.012), STEEL)
            _box(yard, (x, side * 0.24, 0.46), (0.058, 0.02, 0.06), RED)
            for dx in (-0.04, 0.0, 0.04):
                _rivet(yard, np.array([x + dx, side * 0.52, 0.613]), np.array([0.0, 0.0, 1.0]), 0.007)
                _rivet(yard, np.array([x + dx, side * 0.262, 0.46]), np.array([0.0, side, 0.0]), 0.007)
        _tube(yard, (1.50, side * 0.28, 0.50), (1.66, side * 0.28, 0.50), 0.03, STEEL)
        _tube(yard, (1.66, side * 0.28, 0.50), (1.68, side * 0.28, 0.50), 0.075, BLACK)
    for k in range(13):
        y = 0.42 * (k - 6) / 6
        _tube(yard, (1.52, y, 0.44), (1.84 - 0.5 * abs(y), 0.75 * y, 0.07), 0.013, RED)
    _box(yard, (1.50, 0.0, 0.48), (0.02, 0.46, 0.06), RED)


def _wheel(yard: Yard, centre: tuple, radius: float, spokes: int, group: str) -> None:
    """A tyre and a rim of segments, spokes, a hub, and bolts on all of them."""
    middle = np.array(centre)
    side = 1.0 if middle[1] > 0 else -1.0
    segments = 24
    for k in range(segments):
        a, b = tau * k / segments, tau * (k + 0.97) / segments
        for inner, outer, width, material in ((0.90, 1.0, 0.05, STEEL), (0.78, 0.895, 0.035, RED)):
            sections = [
                [
                    middle + radius * r * np.array([cos(t), 0.0, sin(t)]) + (0.0, y, 0.0)
                    for r, y in _around_box((inner, outer), (-width / 2, width / 2))
                ]
                for t in (a, (a + b) / 2, b)
            ]
            yard.loft(sections, material, group)
        bolt = middle + radius * 0.84 * np.array([cos(a + 0.1), 0.0, sin(a + 0.1)])
        _rivet(yard, bolt + (0.0, side * 0.018, 0.0), np.array([0.0, side, 0.0]), 0.009, group)
    for k in range(spokes):
        out = np.array([cos(tau * k / spokes), 0.0, sin(tau * k / spokes)])
        _tube(yard, middle + 0.2 * radius * out, middle + 0.78 * radius * out, 0.012, RED, group)
    _tube(yard, middle - (0.0, 0.03, 0.0), middle + (0.0, 0.03, 0.0), 0.2 * radius, BLACK, group)
    _tube(yard, middle, middle + (0.0, side * 0.05, 0.0), 0.08 * radius, BRASS, group)


def _rods(yard: Yard, side: float) -> None:
    """The rods between the large wheels go with these."""
    y = side * (GAUGE + 0.07)
    for a, b in pairwise(DRIVERS):
        _box(yard, ((a + b) / 2, y, 0.22), ((b - a) / 2, 0.012, 0.022), STEEL, "Drivers")
    for x in DRIVERS:
        _tube(yard, (x, y - side * 0.03, 0.22), (x, y + side * 0.03, 0.22), 0.034, BRASS, "Drivers")
    _box(yard, (0.88, y, 0.36), (0.16, 0.07, 0.09), BLACK)


def _outward(angle: float) -> np.ndarray:
    return np.array([0.0, cos(angle), sin(angle)])


def _around(x: float, angle: float, radius: float) -> np.ndarray:
    return np.array([x, 0.0, BOILER]) + radius * _outward(angle)


def _around_box(first: tuple[float, float], second: tuple[float, float]) -> list[tuple[float, float]]:
    """The corners of a rectangle, from its first side towards the second."""
    (a, b), (c, d) = first, second
    return [(a, c), (b, c), (b, d), (a, d)]


def _curved(
    yard: Yard, along: tuple[float, float], angle: float, width: float, radius: float, material: int
) -> None:
    turns = [angle + width * (k / 3 - 0.5) for k in range(4)]
    corners = _around_box(along, (radius - 0.012, radius))
    yard.loft([[_around(x, turn, r) for x, r in corners] for turn in turns], material)


def _sector(yard: Yard, back: float, front: float, angle: float, width: float, radius: float) -> None:
    arc = [_around(0.0, angle + width * (k / 3 - 0.5), radius) for k in range(4)]
    flat = np.array([_around(0.0, angle, 0.02), *arc])
    yard.loft([flat + (x, 0.0, 0.0) for x in (back, front)], BLACK)


def _box(yard: Yard, centre: tuple, half: tuple, material: int, *groups: str, turn: float = 0.0) -> None:
    corners = np.array([[(x, y, z) for y, z in _around_box((-1, 1), (-1, 1))] for x in (-1, 1)]) * half
    spin = np.array([[1, 0, 0], [0, cos(turn), -sin(turn)], [0, sin(turn), cos(turn)]])
    yard.loft(corners @ spin.T + centre, material, *groups)


def _axes(along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two directions across another one."""
    first = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    first /= np.linalg.norm(first)
    return first, np.cross(along, first)


def _tube(yard: Yard, start, end, radius: float, material: int, *groups: str) -> None:
    start, end, sides = np.asarray(start, float), np.asarray(end, float), 10
    first, second = _axes((end - start) / np.linalg.norm(end - start))
    turns = [tau * k / sides for k in range(sides)]
    circle = np.array([radius * (cos(turn) * first + sin(turn) * second) for turn in turns])
    yard.loft([start + circle, end + circle], material, *groups)


def _ring(yard: Yard, foot: tuple, radius: float, height: float, material: int, *groups: str) -> None:
    corners = _around_box((0.0, height), (radius - 0.015, radius))
    for k in range(12):
        turns = [tau * (k / 12 + share) for share in (0.0, 0.04, 0.08)]
        sections = [[foot + np.array([r * cos(t), r * sin(t), z]) for z, r in corners] for t in turns]
        yard.loft(sections, material, *groups)


def _rivet(yard: Yard, place: np.ndarray, out: np.ndarray, radius: float, *groups: str) -> None:
    """Half a ball."""
    first, second = _axes(out)
    sides, points = 6, []
    for level, height in ((1.0, 0.0), (0.75, 0.6)):
        for k in range(sides):
            turn = tau * k / sides
            points.append(place + radius * (level * (cos(turn) * first + sin(turn) * second) + height * out))
    points.append(place + radius * 0.9 * out)
    faces = [(k, (k + 1) % sides, (k + 1) % sides + sides, k + sides) for k in range(sides)]
    faces += [(k + sides, (k + 1) % sides + sides, 2 * sides) for k in range(sides)]
    material = BRASS if "Cab" not in groups else BLACK
    yard.add(np.array(points), faces, material, *groups)


def _ball(yard: Yard, centre: tuple, radius: float, material: int) -> None:
    _rivet(yard, np.array(centre), np.array([0.0, 0.0, 1.0]), radius)
