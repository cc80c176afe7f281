# SPDX-License-Identifier: GPL-3.0-or-later
"""Methods with a lattice of control points: the artist moves these, or drags the shape itself."""

from collections.abc import Mapping
from typing import Any

from .schema import Box, Choice, Control, Family, Float, Int, Method, Moved, Posed, Reproduced

_SPLINES = (
    ("bspline", "B-Spline", "Smooth, and each point reaches some cells; the degree says how smooth"),
    (
        "bezier",
        "Bezier",
        "One polynomial along each axis: each point reaches everything. Up to 16 points along an axis",
    ),
)


def _inverse_seconds(points: int, handles: int, options: Mapping[str, Any]) -> float:
    """Points are placed, and a matrix of the handles or of the lattice, whichever is smaller, is inverted."""
    fewer = min(handles, options["resolution"] ** 3)
    return 3e-7 * points + 1e-9 * fewer**3


def _seconds(points: int, _size: int, _options: Mapping[str, Any]) -> float:
    """A lattice of equal cells has a closed form; any other takes some microseconds per point."""
    return 3e-6 * points


ROWS = (
    Method(
        id="ffd",
        number=40,
        label="Free-Form Deformation",
        family=Family.SPACE_LINEAR,
        control=Control.LATTICE,
        native="Ffd",
        section="5.1",
        paper="Sederberg & Parry 1986, Coquillart 1990",
        summary="A lattice of control points moves what lies inside: smooth, fast, at any resolution",
        moves=frozenset(Moved),
        bind_seconds=_seconds,
        reproduces=Reproduced.AFFINE_MAPS,
        parameters=(
            Choice(
                "basis",
                "bspline",
                (
                    *_SPLINES,
                    (
                        "blender",
                        "As in Blender",
                        "What the interpolation types of the lattice say: the shape of Blender's modifier",
                    ),
                ),
                rebinds=True,
                label="Interpolation",
                description="How the points of the lattice blend. Hexahedra blend within their cells",
            ),
            Int(
                "degree",
                3,
                minimum=1,
                maximum=5,
                soft_maximum=5,
                rebinds=True,
                only_with=("basis", ("bspline",)),
                unit="degree of the polynomials",
                label="Degree",
                description="1 is straight from point to point; higher degrees are smoother and reach "
                "farther. An axis with fewer points has a lower degree",
            ),
            Choice(
                "outside",
                "follow",
                (
                    ("follow", "Follow", "The motion at the border goes on outside"),
                    (
                        "freeze",
                        "Stay",
                        "Some planes of points beside each border stay at rest, and so does all outside",
                    ),
                ),
                rebinds=True,
                only_with=("basis", ("bspline", "bezier")),
                label="Outside",
                description="What happens outside the lattice",
            ),
            Int(
                "continuity",
                1,
                minimum=0,
                maximum=4,
                soft_maximum=2,
                rebinds=True,
                advanced=True,
                only_with=("outside", ("freeze",)),
                unit="continuous derivatives",
                label="Continuity",
                description="How smoothly the deformation ends at the border, if all outside stays: that "
                "many planes of points and one more stay beside each border",
            ),
            Int(
                "smooth",
                1,
                minimum=0,
                maximum=4,
                soft_maximum=3,
                rebinds=True,
                advanced=True,
                unit="steps of subdivision",
                label="Smooth",
                description="How often a lattice of hexahedra is subdivided; 0 bends at each of its faces",
            ),
        ),
    ),
    Method(
        id="inverse_ffd",
        number=41,
        label="Inverse Free-Form Deformation",
        family=Family.SPACE_LINEAR,
        native="InverseFfd",
        section="5.1",
        paper="Hsu, Hughes & Kaufman 1992",
        summary="Drag places of the shape; a hidden lattice bends space around them, and what is far stays",
        moves=frozenset(Moved),
        posed=Posed.POINTS,
        bind_seconds=_inverse_seconds,
        reproduces=Reproduced.REST,
        parameters=(
            Int(
                "resolution",
                5,
                minimum=2,
                maximum=16,
                soft_maximum=10,
                rebinds=True,
                unit="control points along each axis",
                label="Resolution",
                description="Points of the hidden lattice along each axis: more let a drag reach less far",
            ),
            Choice(
                "basis",
                "bspline",
                _SPLINES,
                rebinds=True,
                advanced=True,
                label="Interpolation",
                description="How the points of the hidden lattice blend",
            ),
            Int(
                "degree",
                3,
                minimum=1,
                maximum=5,
                soft_maximum=5,
                rebinds=True,
                advanced=True,
                only_with=("basis", ("bspline",)),
                unit="degree of the polynomials",
                label="Degree",
                description="Higher degrees are smoother and reach farther",
            ),
            Float(
                "cut_off",
                1e-3,
                minimum=1e-6,
                maximum=0.5,
                soft_maximum=0.1,
                precision=5,
                rebinds=True,
                advanced=True,
                unit="share of the most visible direction",
                label="Cut-Off",
                description="Moves of the lattice that the handles hardly see stay still. A higher value is "
                "calmer where handles are close to each other, and meets them less exactly",
            ),
            Box(
                "frame",
                types=("EMPTY",),
                rebinds=True,
                advanced=True,
                label="Box",
                description="An empty whose cube, of size 1, the hidden lattice fills; without one, it fills "
                "a box around the surface, along the axes of that",
            ),
        ),
    ),
)
