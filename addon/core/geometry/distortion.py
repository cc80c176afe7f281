# SPDX-License-Identifier: GPL-3.0-or-later
"""How much a surface is stretched between its rest shape and the shape that is shown.

On each triangle the map is linear. Its singular values s1 >= s2 do not depend on rotations and translations:
a small circle becomes an ellipse whose half axes are s1 and s2 times the radius of the circle. Both follow
from the 2x2 metric tensors G (rest) and H (shown), whose entries are the scalar products of two edges: with
the Cholesky factors G = R'R and H = S'S, the map in the plane of the triangle is J = S R^-1, upper
triangular, and

    s1 + s2 = |(J11 + J22, J12)|        s1 - s2 = |(J11 - J22, J12)|

which stays exact where s1 = s2, unlike the roots of the characteristic polynomial. P. Sander, J. Snyder,
S. Gortler, H. Hoppe, "Texture Mapping Progressive Meshes", SIGGRAPH 2001, pp. 409-416, section 3.
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np

COLLAPSED = 1e-3  # smaller singular values count as this one, which keeps all measures finite
_FLAT = 1e-12  # a rest triangle has no shape to compare if its height is a smaller share of its longest edge


class Measure(Enum):
    """What a colour means.

    Each measure is a ratio: 1 at rest, and the same under rotations and translations.
    """

    AREA = "AREA"
    """s1 s2, the change of area. P. Degener, J. Meseth, R. Klein, "An Adaptable Surface Parameterization
    Method", IMR 2003, pp. 201-213."""

    ANGLE = "ANGLE"
    """s1 / s2 >= 1, the shear: the length of an ellipse that was a circle, divided by its width. K. Hormann,
    G. Greiner, "MIPS: An Efficient Global Parametrization Method", Curve and Surface Design 1999,
    pp. 153-162 (they use the sum of this ratio and its inverse)."""

    STRETCH = "STRETCH"
    """s1, the stretch along the direction that is stretched most. It is below 1 only if all directions are
    compressed. P. Sander, J. Snyder, S. Gortler, H. Hoppe 2001 (as above), its worst-case norm."""

    DIRICHLET = "DIRICHLET"
    """(s1^2 + s2^2 + 1 / s1^2 + 1 / s2^2) / 4 >= 1, any change of shape or size in one number. The paper's
    energy is 4 at rest; divided by 4 it is 1. J. Smith, S. Schaefer, "Bijective Parameterization with Free
    Boundaries", SIGGRAPH 2015, article 70."""

    @property
    def two_sided(self) -> bool:
        """Whether values below 1 mean compressed, and values above 1 stretched."""
        return self in (Measure.AREA, Measure.STRETCH)


@dataclass(frozen=True)
class RestMetric:
    """The part of the computation that depends on the rest shape alone.

    ``triangles`` (t, 3). The factor R of each triangle, (t,) each: ``length`` of the first edge, ``shift`` of
    the second edge along the first, ``height`` of the second edge across the first. ``area`` (t,) is 0 for
    triangles without a shape, which count as unchanged.
    """

    count: int
    triangles: np.ndarray
    length: np.ndarray
    shift: np.ndarray
    height: np.ndarray
    area: np.ndarray
    vertex_area: np.ndarray  # (n,), the sum over the triangles around each vertex


def rest_metric(points: np.ndarray, triangles: np.ndarray) -> RestMetric:
    """The metric of a rest shape with ``points`` (n, 3) and ``triangles`` (t, 3)."""
    length, shift, height = _factor(points, triangles)
    longest = np.maximum(length, np.hypot(shift, height))
    sound = (height > _FLAT * longest) & (length > _FLAT * longest) & np.isfinite(height)
    area = np.where(sound, 0.5 * length * height, 0.0)
    length, height = np.where(sound, length, 1.0), np.where(sound, height, 1.0)
    shift = np.where(sound, shift, 0.0)
    vertex_area = _sum_at_vertices(area, triangles, len(points))
    return RestMetric(len(points), triangles, length, shift, height, area, vertex_area)


def singular_values(rest: RestMetric, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """s1 >= s2 >= 0, (t,) each, from rest to ``points`` (n, 3).

    Both are 1 where the rest triangle has no shape.
    """
    length, shift, height = _factor(points, rest.triangles)
    a, d = length / rest.length, height / rest.height
    b = (shift - a * rest.shift) / rest.height
    half_sum, half_difference = 0.5 * np.hypot(a + d, b), 0.5 * np.hypot(a - d, b)
    largest = half_sum + half_difference
    with np.errstate(invalid="ignore", divide="ignore"):
        smallest = np.where(largest > 0.0, a * d / largest, 0.0)
    known = (rest.area > 0.0) & np.isfinite(largest)
    return np.where(known, largest, 1.0), np.where(known, smallest, 1.0)


def ratio(measure: Measure, largest: np.ndarray, smallest: np.ndarray) -> np.ndarray:
    """The value (t,) of a measure for singular values (t,)."""
    s1, s2 = np.maximum(largest, COLLAPSED), np.maximum(smallest, COLLAPSED)
    if measure is Measure.AREA:
        return s1 * s2
    if measure is Measure.ANGLE:
        return s1 / s2
    if measure is Measure.STRETCH:
        return s1
    squares = s1 * s1 + s2 * s2
    return 0.25 * (squares + squares / (s1 * s2) ** 2)


def at_vertices(rest: RestMetric, values: np.ndarray) -> np.ndarray:
    """The geometric mean (n,) of the ratios (t,) of the triangles around each vertex, weighted by rest area.

    A vertex without triangles has the ratio 1.
    """
    total = _sum_at_vertices(rest.area * np.log(values), rest.triangles, rest.count)
    return np.exp(total / np.where(rest.vertex_area > 0.0, rest.vertex_area, 1.0))


def worst(values: np.ndarray) -> int:
    """The vertex whose ratio differs most from 1, as a factor."""
    return int(np.argmax(np.abs(np.log(values))))


def _factor(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The upper triangular factor of each triangle's metric tensor, with a diagonal >= 0; (t,) each."""
    x, y, z = (np.ascontiguousarray(axis, dtype=np.float64) for axis in points.T)
    first, second, third = (np.ascontiguousarray(corner) for corner in triangles.T)
    e = [axis[second] - axis[first] for axis in (x, y, z)]
    f = [axis[third] - axis[first] for axis in (x, y, z)]
    length = np.sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2])
    shared = e[0] * f[0] + e[1] * f[1] + e[2] * f[2]
    across = np.sqrt(
        (e[1] * f[2] - e[2] * f[1]) ** 2 + (e[2] * f[0] - e[0] * f[2]) ** 2 + (e[0] * f[1] - e[1] * f[0]) ** 2
    )
    pointed = length == 0.0
    divisor = np.where(pointed, 1.0, length)
    height = across / divisor
    if pointed.any():
        height = np.where(pointed, np.sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]), height)
    return length, shared / divisor, height


def _sum_at_vertices(values: np.ndarray, triangles: np.ndarray, count: int) -> np.ndarray:
    """For each vertex the sum (count,) of the values (t,) of its triangles."""
    return sum(np.bincount(corner, values, count) for corner in triangles.T) + np.zeros(count)
