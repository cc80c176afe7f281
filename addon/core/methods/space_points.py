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
_FIT = 2e-8  # seconds per square of the centres that a fit chooses
_FITTED = 400  # handle points; with more of them, centres are chosen


def _rbf_seconds(points: int, size: int, options: Mapping[str, Any]) -> float:
    """A dense system, or a fit of some points at first; then the functions of the handles at each point."""
    exact = size <= _FITTED or options["tolerance"] == 0.0 or options["kernel"].startswith("wendland")
    centres = size if exact else min(size, 800)
    system = _DENSE * centres**3 if exact else _FIT * centres**2
    return system + 5e-6 * size + 2e-9 * points * centres


ROWS = (
    Method(
        id="rbf",
        number=30,
        label="Smooth Points",
        known_as="Radial Basis Functions",
        search="face markers cloud points mocap",
        family=Family.SPACE_LINEAR,
        native="Rbf",
        section="5.3",
        paper="Duchon 1977, Botsch & Kobbelt 2005",
        summary="Meets many markers as smoothly as can be",
        fails="Pinches what is twisted",
        picture="gallery: branches",
        main=("kernel",),
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
                description="Choose how the pull of a marker fades with the distance",
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
                description="Set how far a handle point reaches, relative to the diameter of a ball around "
                "all of them",
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
                description="Keep moves (0) or stretches and shears, too (1 and 2) as they are; -1 lets a "
                "compact kernel leave all beyond its radius at rest",
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
                description="Speed up handles of many points, which are met up to this share of their "
                "longest move; 0 meets all exactly",
            ),
            stored_precision("the functions of handles"),
        ),
        reproduces=Reproduced.AFFINE_MAPS,
    ),
    Method(
        id="space_propagation",
        number=32,
        label="Falloff Points",
        known_as="Space Propagation",
        search="proportional soft selection magnet falloff",
        family=Family.SPACE_LINEAR,
        native="SpacePropagation",
        section="5.2",
        paper="Pauly et al. 2003",
        summary="Lets a move fade with the distance by a curve that you draw",
        fails="Keeps nothing stiff",
        picture="gallery: branches",
        main=("transfer",),
        moves=frozenset(Moved),
        bind_seconds=lambda points, size, _options: 8e-8 * points * size**0.5,
        posed=Posed.CONTROL,
        reproduces=Reproduced.AFFINE_MAPS,
        parameters=(
            Curve(
                "transfer",
                ((0.0, 0.0), (1.0, 1.0)),
                rebinds=True,
                label="Falloff Curve",
                description="Draw how much of the motion of a handle is left, from the other handles "
                "(left) to the handle itself (right)",
            ),
        ),
    ),
    Method(
        id="multiresolution_space",
        number=35,
        label="Keep Details",
        known_as="Multiresolution in Space",
        search="details bumps sculpt",
        family=Family.MULTIRESOLUTION,
        native="MultiresolutionSpace",
        section="5.3",
        paper="Marinov, Botsch & Kobbelt 2007",
        summary="Turns bumps with the space instead of shearing them",
        fails="Bends no better than the method that it is put around",
        picture="space_details",
        main=("wavelength",),
        bind_seconds=factorising(0.06),
        reproduces=Reproduced.RIGID_MOTIONS,
        posed=Posed.CONTROL,
        wraps=(Family.SPACE_LINEAR, Family.SPACE_NONLINEAR),
        parameters=multiresolution.ROWS[0].parameters,
    ),
    Method(
        id="mls",
        number=31,
        label="Rigid Points",
        known_as="Moving Least Squares",
        search="pin puppet empties bones text hair loose",
        family=Family.SPACE_NONLINEAR,
        native="Mls",
        section="7",
        paper="Schaefer, McPhail & Warren 2006, Zhu & Gortler 2007",
        summary="Moves loose parts, text and hair by empties or bones, without stretch",
        fails="Tears where handles are close together",
        picture="machine",
        main=("alpha",),
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
                description="Choose what each point may do: turn, turn and grow, or shear, too",
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
                description="Let each point follow more only the nearest handles; regions of many points "
                "need more than 1.5",
            ),
            stored_precision("the weights of handles"),
        ),
    ),
)
