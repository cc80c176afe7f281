# SPDX-License-Identifier: GPL-3.0-or-later
"""Space methods that the points of handles move."""

from collections.abc import Mapping
from typing import Any

from . import multiresolution
from .schema import (
    Choice,
    Curve,
    Family,
    Float,
    Int,
    Method,
    Moved,
    Posed,
    Reproduced,
    Size,
    factorising,
    per_pair,
    stored_precision,
)

_DENSE = 3e-11  # seconds per cube of the handle points, for their system
_FIT = 1e-7  # seconds per square of the centres that a fit chooses
_FITTED = 400  # handle points; with more of them, centres are chosen


def _rbf_seconds(points: int, size: int, options: Mapping[str, Any]) -> float:
    """A dense system, or a fit of some points at first; then the functions of the handles at each point."""
    exact = size <= _FITTED or options["tolerance"] == 0.0 or options["kernel"].startswith("wendland")
    centres = size if exact else min(size, 2500)
    system = _DENSE * centres**3 if exact else _FIT * centres**2
    return system + 2e-9 * points * centres


ROWS = (
    Method(
        id="rbf",
        number=30,
        label="Radial Basis Functions",
        family=Family.SPACE_LINEAR,
        native="Rbf",
        section="5.3",
        paper="Duchon 1977, Botsch & Kobbelt 2005",
        summary="The smoothest deformation of space that meets all handles: for loose parts, curves and "
        "point clouds",
        moves=frozenset(Moved),
        bind_seconds=_rbf_seconds,
        posed=Posed.CONTROL,
        parameters=(
            Choice(
                "kernel",
                "triharmonic",
                (
                    ("triharmonic", "Triharmonic", "The smoothest: nothing shows where handles are"),
                    ("biharmonic", "Biharmonic", "Calmer far away from handles; single points pull cones"),
                    ("wendland_c2", "Compact, Smooth", "Each point reaches as far as the radius"),
                    ("wendland_c4", "Compact, Smoother", "The same, smoother and more pointed"),
                ),
                rebinds=True,
                label="Kernel",
                description="How the influence of a handle point changes with the distance",
            ),
            Float(
                "radius",
                0.5,
                minimum=1e-3,
                maximum=1e3,
                soft_maximum=2.0,
                rebinds=True,
                only_with=("kernel", ("wendland_c2", "wendland_c4")),
                unit="size of all handles",
                share_of=Size.HANDLES,
                label="Radius",
                description="How far a handle point reaches, relative to the diameter of a ball around all "
                "of them",
            ),
            Int(
                "degree",
                2,
                minimum=-1,
                maximum=2,
                soft_maximum=2,
                rebinds=True,
                advanced=True,
                unit="degree",
                label="Degree",
                description="Maps of space up to this degree are kept as they are: 0 for moves, 1 for affine "
                "maps. The triharmonic kernel uses at least 1, the others at most 1. With -1, a compact "
                "kernel leaves everything beyond its radius at rest",
            ),
            Float(
                "tolerance",
                1e-4,
                maximum=0.1,
                soft_maximum=0.01,
                precision=6,
                step=0.001,
                rebinds=True,
                advanced=True,
                unit="share of the longest move",
                label="Tolerance",
                description="Handles of many points are met up to this share of their longest move, with as "
                "few radial functions as that takes. 0 meets all exactly, which takes long",
            ),
            stored_precision("the functions of handles"),
        ),
        reproduces=Reproduced.AFFINE_MAPS,
    ),
    Method(
        id="space_propagation",
        number=32,
        label="Space Propagation",
        family=Family.SPACE_LINEAR,
        native="SpacePropagation",
        section="5.2",
        paper="Pauly et al. 2003",
        summary="Lets the motion of a handle fade with the distance by a curve, for any points: quick, and "
        "never stiff",
        moves=frozenset(Moved),
        bind_seconds=per_pair(2e-8),
        posed=Posed.CONTROL,
        reproduces=Reproduced.AFFINE_MAPS,
        parameters=(
            Curve(
                "transfer",
                ((0.0, 0.0), (1.0, 1.0)),
                rebinds=True,
                label="Falloff Curve",
                description="How much of the motion of a handle is left, from the other handles (left) "
                "to the handle itself (right)",
            ),
        ),
    ),
    Method(
        id="multiresolution_space",
        number=35,
        label="Multiresolution in Space",
        family=Family.MULTIRESOLUTION,
        native="MultiresolutionSpace",
        section="5.3",
        paper="Marinov, Botsch & Kobbelt 2007",
        summary="Moves a smooth base by a space method and puts the details back, turned with it",
        bind_seconds=factorising(0.06),
        reproduces=Reproduced.RIGID_MOTIONS,
        posed=Posed.CONTROL,
        wraps=(Family.SPACE_LINEAR, Family.SPACE_NONLINEAR),
        parameters=multiresolution.ROWS[0].parameters,
    ),
    Method(
        id="mls",
        number=31,
        label="Moving Least Squares",
        family=Family.SPACE_NONLINEAR,
        native="Mls",
        section="7",
        paper="Schaefer, McPhail & Warren 2006, Zhu & Gortler 2007",
        summary="Each point moves by the rigid map that fits the handles near it best: details turn along",
        moves=frozenset(Moved),
        bind_seconds=per_pair(8e-9),
        posed=Posed.CONTROL,
        takes_segments=True,
        reproduces=Reproduced.RIGID_MOTIONS,
        parameters=(
            Choice(
                "maps",
                "rigid",
                (
                    ("rigid", "Rigid", "Details keep their shape and size"),
                    ("similarity", "Similarity", "Details may grow and shrink, too"),
                    ("affine", "Affine", "Details may shear; needs handles that do not lie in a plane"),
                ),
                rebinds=True,
                label="Maps",
                description="The maps that are fitted to the handles at each point",
            ),
            Float(
                "alpha",
                2.0,
                minimum=0.1,
                maximum=8.0,
                soft_maximum=4.0,
                precision=2,
                step=0.1,
                earlier=(1.0, 1),
                rebinds=True,
                label="Falloff",
                unit="exponent",
                description="The larger, the more each point follows only the nearest handles. Regions of "
                "many points need more than 1.5: with less, far points of a region outweigh its border",
            ),
            stored_precision("the weights of handles"),
        ),
    ),
)
