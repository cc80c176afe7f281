# SPDX-License-Identifier: GPL-3.0-or-later
"""Spot gets two humps and a longer muzzle: strokes redraw the outline, and the surface follows."""

from __future__ import annotations

import math
from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Matrix

from .. import materials, posing
from ..lineup import Lineup
from ..models import spot
from ..studio import Shot

SIDE = Matrix.Rotation(0.5 * math.pi, 4, "X")  # a camera that looks along y
INK = (0.85, 0.20, 0.02)
# Points (x, z) of the outline of the back, from the tail to the neck.
BACK = ((-0.95, 0.84), (-0.9, 0.9), (-0.8, 0.945), (-0.5, 0.97), (-0.3, 1.05), (-0.2, 1.06), (-0.12, 1.18))
MUZZLE = ((0.5, 1.45), (0.7, 1.31), (0.93, 1.18), (1.04, 1.05), (1.0, 0.93), (0.8, 0.88), (0.42, 0.84))
HUMP = 0.27
REACHES = (0.22, 0.25)


def make() -> bpy.types.Scene:
    return Lineup(
        title="Silhouette",
        build=spot.build,
        row=dict.fromkeys(("Strokes", "Draw Outline")),
        spacing=2.75,
        frame=1,
        finish=sketch,
        shot=Shot(
            (0.05, 0.0, 0.80),
            width=5.4,
            elevation=4.0,
            distance=26.0,
            lit=0.8,
            light=6.0,
            picture=(1080, 430),
            text=0.15,
            front=-1.30,
            aside=-0.15,
        ),
    ).make()


def sketch(cows: Sequence[bpy.types.Object]) -> None:
    cow = cows[-1]
    cow.data = cow.data.copy()  # shape keys belong to the mesh
    for each in cows:
        posing.subdivide(each)
    before = posing.shape(cow)
    for name, line, reach in zip(("Back", "Muzzle"), (humps(), np.array(MUZZLE)), REACHES):
        add_stroke(f"{name} Stroke", line, cows[0])
        stroke = add_stroke(name, line, cow)
        posing.make_active(cow)
        answer = bpy.ops.sinew.silhouette_sketch(stroke=stroke.name, view=SIDE, reach=reach)
        posing.expect(answer, f"the sketch of the {name.lower()}")
        stroke.hide_render = True
    bpy.context.view_layer.update()
    after = posing.shape(cow)
    travel = np.linalg.norm(after - before, axis=1).max()
    if not np.isfinite(after).all() or not 0.2 < travel < 1.0:
        raise posing.SampleError(f"the strokes move vertices by {travel:.3g}")


def humps() -> np.ndarray:
    """The outline of the back with two humps, (n, 2)."""
    x = np.linspace(BACK[0][0], BACK[-1][0], 80)
    share = (x - x[0]) / (x[-1] - x[0])
    return np.column_stack((x, np.interp(x, *np.transpose(BACK)) + HUMP * np.sin(2.0 * np.pi * share) ** 2))


def add_stroke(name: str, line: np.ndarray, cow: bpy.types.Object) -> bpy.types.Object:
    """A curve through points (n, 2) in the plane before the cow; a "Stroke" is drawn in ink."""
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions = "3D"
    spline = curve.splines.new("POLY")
    spline.points.add(len(line) - 1)
    for point, (x, z) in zip(spline.points, line):
        point.co = (cow.location.x + x, -0.55, z, 1.0)
    if name.endswith("Stroke"):
        curve.bevel_depth = 0.012
        curve.materials.append(materials.plain_material("Stroke", INK, roughness=0.6))
    return posing.add_object(name, curve)
