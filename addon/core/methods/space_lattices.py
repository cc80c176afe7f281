# SPDX-License-Identifier: GPL-3.0-or-later
"""Methods with a lattice of control points: the artist moves these, or drags the shape itself."""

from collections.abc import Mapping
from typing import Any

from .schema import Box, Choice, Control, Family, Float, Int, Method, Moved, Posed, Reproduced, Span, items

_SPLINES = items(
    bspline=("B-Spline", "Smooth, and each point reaches some cells; the degree says how smooth"),
    bezier="One polynomial along each axis: each point reaches everything; up to 16 points along an axis",
)
_BASES = _SPLINES + items(
    blender=(
        "Blender's Lattice",
        "What the interpolation types of the lattice say: the shape of Blender's modifier",
    )
)
_OUTSIDE = items(
    follow="The motion at the border goes on outside",
    freeze=("Stay", "Some planes of points beside each border stay at rest, and so does all outside"),
)


def _inverse_seconds(points: int, handles: int, options: Mapping[str, Any]) -> float:
    """Points are placed, and a matrix of the handles or of the lattice, whichever is smaller, is inverted."""
    fewer = min(handles, options["resolution"] ** 3)
    return 3e-7 * points + 8e-10 * handles * fewer**2 + 1e-9 * fewer**3


def _seconds(points: int, _size: int, _options: Mapping[str, Any]) -> float:
    """A lattice of equal cells has a closed form; any other takes longer per point."""
    return 8e-7 * points


ROWS = (
    Method(
        id="ffd",
        number=40,
        label="Lattice",
        known_as="Free-Form Deformation",
        search="lattice box squash stretch taper",
        family=Family.SPACE_LINEAR,
        section="5.1",
        paper="Sederberg & Parry 1986, Coquillart 1990",
        summary="Bends everything in a box of points, several objects at once",
        fails="Pinches what is twisted",
        picture="longship: one lattice",
        control=Control.LATTICE,
        moves=frozenset(Moved),
        bind_seconds=_seconds,
        reproduces=Reproduced.AFFINE_MAPS,
        parameters=(
            Choice(
                "basis",
                "Interpolation",
                "bspline",
                _BASES,
            ).described("Choose how the points of the lattice blend"),
            Int(
                "degree",
                "Degree",
                3,
                Span(1, 5, soft=5),
                only_with=("basis", ("bspline",)),
                unit="degree of the polynomials",
            ).described(
                "Smooth the lattice by higher degrees, which reach farther; 1 is straight from point to point"
            ),
            Choice(
                "outside",
                "Outside",
                "follow",
                _OUTSIDE,
                only_with=("basis", ("bspline", "bezier")),
            ).described("Choose what happens outside the lattice"),
            Int(
                "continuity",
                "Continuity",
                1,
                Span(0, 4, soft=2),
                advanced=True,
                only_with=("outside", ("freeze",)),
                unit="continuous derivatives",
            ).described(
                "Set how smoothly the motion ends at the border, where so many planes of "
                "points and one more stay"
            ),
            Int(
                "smooth", "Smooth", 1, Span(0, 4, soft=3), advanced=True, unit="steps of subdivision"
            ).described("Set how often a lattice of hexahedra is subdivided; 0 bends at each of its faces"),
        ),
    ),
    Method(
        id="inverse_ffd",
        number=41,
        label="Drag Points",
        known_as="Inverse Free-Form Deformation",
        search="pull place text logo",
        family=Family.SPACE_LINEAR,
        section="5.1",
        paper="Hsu, Hughes & Kaufman 1992",
        summary="Pulls at places of text, curves or meshes; what is far stays",
        fails="Shears bumps",
        picture="inverse_ffd",
        moves=frozenset(Moved),
        posed=Posed.POINTS,
        bind_seconds=_inverse_seconds,
        reproduces=Reproduced.REST,
        main=("resolution",),
        parameters=(
            Int(
                "resolution", "Resolution", 5, Span(2, 16, soft=10), unit="control points along each axis"
            ).described("Let a drag reach less far by more points of the hidden lattice along each axis"),
            Choice("basis", "Interpolation", "bspline", _SPLINES, advanced=True).described(
                "Set how the points of the hidden lattice blend"
            ),
            Int(
                "degree",
                "Degree",
                3,
                Span(1, 5, soft=5),
                advanced=True,
                only_with=("basis", ("bspline",)),
                unit="degree of the polynomials",
            ).described("Smooth the hidden lattice by higher degrees, which reach farther"),
            Float(
                "cut_off",
                "Cut-Off",
                1e-3,
                Span(1e-6, 0.5, soft=0.1, digits=5),
                advanced=True,
                unit="share of the most visible direction",
            ).described(
                "Calm the shape where handles are close to each other; higher values meet them less exactly"
            ),
            Box("frame", "Box", types=("EMPTY",), advanced=True).described(
                "Choose an empty whose cube of size 1 the hidden lattice fills; without one, "
                "it fills a box around the surface"
            ),
        ),
    ),
)
