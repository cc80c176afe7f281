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
    Span,
    factorising,
    items,
    per_pair,
    stored_precision,
)

_POINTS: dict[str, Any] = {"moves": frozenset(Moved), "posed": Posed.CONTROL}


_KERNELS = items(
    triharmonic="The smoothest: nothing shows where handles are",
    biharmonic="Calmer far away from handles; single points pull cones",
    wendland_c2=("Compact, Smooth", "Each point reaches as far as the radius"),
    wendland_c4=("Compact, Smoother", "The same, smoother and more pointed"),
)

_MAPS = items(
    rigid="Details keep their shape and size",
    similarity="Details may grow and shrink, too",
    affine="Details may shear; needs handles that do not lie in a plane",
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
        section="5.3",
        paper="Duchon 1977, Botsch & Kobbelt 2005",
        summary="Meets many markers as smoothly as can be",
        fails="Pinches what is twisted",
        picture="gallery: branches",
        bind_seconds=_rbf_seconds,
        reproduces=Reproduced.AFFINE_MAPS,
        **_POINTS,
        main=("kernel",),
        parameters=(
            Choice("kernel", "Kernel", "triharmonic", _KERNELS).described(
                "Choose how the pull of a marker fades with the distance"
            ),
            Float(
                "radius",
                "Radius",
                0.5,
                Span(1e-3, 1e3, soft=2.0),
                only_with=("kernel", ("wendland_c2", "wendland_c4")),
                share_of=Size.HANDLES,
                unit="size of all handles",
            ).described(
                "Set how far a handle point reaches, relative to the diameter of a ball around all of them"
            ),
            Int("degree", "Degree", 2, Span(-1, 2, soft=2), advanced=True, unit="degree").described(
                "Keep moves (0) or stretches and shears, too (1 and 2) as they are; -1 lets a "
                "compact kernel leave all beyond its radius at rest"
            ),
            Float(
                "tolerance",
                "Tolerance",
                1e-4,
                Span(0.0, 0.1, soft=0.01, digits=6, step=0.001),
                advanced=True,
                unit="share of the longest move",
            ).described(
                "Speed up handles of many points, which are met up to this share of their "
                "longest move; 0 meets all exactly"
            ),
            stored_precision("the functions of handles"),
        ),
    ),
    Method(
        id="space_propagation",
        number=32,
        label="Falloff Points",
        known_as="Space Propagation",
        search="proportional soft selection magnet falloff",
        family=Family.SPACE_LINEAR,
        section="5.2",
        paper="Pauly et al. 2003",
        summary="Lets a move fade with the distance by a curve that you draw",
        fails="Keeps nothing stiff",
        picture="gallery: branches",
        bind_seconds=lambda points, size, _options: 8e-8 * points * size**0.5,
        reproduces=Reproduced.AFFINE_MAPS,
        **_POINTS,
        main=("transfer",),
        parameters=(
            Curve("transfer", "Falloff Curve", ((0.0, 0.0), (1.0, 1.0))).described(
                "Draw how much of the motion of a handle is left, from the other handles "
                "(left) to the handle itself (right)"
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
        section="5.3",
        paper="Marinov, Botsch & Kobbelt 2007",
        summary="Turns bumps with the space instead of shearing them",
        fails="Bends no better than the method that it is put around",
        picture="space_details",
        bind_seconds=factorising(0.06),
        reproduces=Reproduced.RIGID_MOTIONS,
        posed=Posed.CONTROL,
        wraps=(Family.SPACE_LINEAR, Family.SPACE_NONLINEAR),
        main=("wavelength",),
        parameters=multiresolution.ROWS[0].parameters,
    ),
    Method(
        id="mls",
        number=31,
        label="Rigid Points",
        known_as="Moving Least Squares",
        search="pin puppet empties bones text hair loose",
        family=Family.SPACE_NONLINEAR,
        section="7",
        paper="Schaefer, McPhail & Warren 2006, Zhu & Gortler 2007",
        summary="Moves loose parts, text and hair by empties or bones, without stretch",
        fails="Tears where handles are close together",
        picture="machine",
        bind_seconds=per_pair(8e-9),
        takes_segments=True,
        reproduces=Reproduced.RIGID_MOTIONS,
        **_POINTS,
        main=("alpha",),
        parameters=(
            Choice("maps", "Maps", "rigid", _MAPS).described(
                "Choose what each point may do: turn, turn and grow, or shear, too"
            ),
            Float(
                "alpha",
                "Falloff",
                2.0,
                Span(0.1, 8.0, soft=4.0, digits=2, step=0.1),
                earlier=(1.0, 1),
                unit="exponent",
            ).described(
                "Let each point follow more only the nearest handles; regions of many points "
                "need more than 1.5"
            ),
            stored_precision("the weights of handles"),
        ),
    ),
)
