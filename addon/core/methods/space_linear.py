# SPDX-License-Identifier: GPL-3.0-or-later
"""Linear space methods: each point is a weighted sum of the vertices of its control."""

from collections.abc import Mapping
from typing import Any

from .schema import (
    BindSeconds,
    Bool,
    Choice,
    Control,
    Family,
    Float,
    Int,
    Method,
    Moved,
    Reproduced,
    Span,
    items,
    per_pair,
    stored_precision,
)

_CAGE: dict[str, Any] = {"control": Control.CAGE, "moves": frozenset(Moved)}


_REFUSED = items(
    error=("Refuse", "The vertices outside are named in an error; nothing moves until they are inside"),
    mean_value=("Follow", "Vertices outside the cage follow it, too"),
)

_OUTSIDE = items(
    nearest=("Nearest Face", "Each vertex outside the cage follows its nearest face"),
    error=("Refuse", "The vertices outside are named in an error; nothing moves until they are inside"),
)

_FACES = items(
    triangles="A quad is cut along a diagonal, which the shape shows",
    quads="A quad is a smooth patch, and a symmetric cage gives symmetric shapes: binding "
    "takes three to five times as long, a frame a third longer",
)


_SMOOTH = items(
    off="The faces of the cage as they are",
    automatic="The smooth surface that a Subdivision modifier would make of the cage, within a thousandth "
    "of its size",
    levels="The smooth surface, with each face split as often as Levels says",
)

SMOOTH = (
    Choice("smooth", "Smooth", "off", _SMOOTH).described(
        "Let the smooth surface of the cage move the mesh, with the creases of the cage: few points pose it, "
        "and a frame takes no longer"
    ),
    Int(
        "levels", "Levels", 2, Span(1, 6, soft=4), only_with=("smooth", ("levels",)), unit="levels"
    ).described(
        "Set how often the faces of the smooth cage are split; each level makes binding four times as long"
    ),
)


def _smooth_faces(faces: int, options: Mapping[str, Any]) -> int:
    """How many triangles the smooth surface of a cage has about; automatic levels end at 20,000 quads."""
    if options["smooth"] == "off":
        return faces
    return min(faces << 6, 40_000) if options["smooth"] == "automatic" else faces << 2 * options["levels"]


def _on_smooth(seconds: BindSeconds) -> BindSeconds:
    """The cost for the faces that a smooth cage has."""
    return lambda points, faces, options: seconds(points, _smooth_faces(faces, options), options)


CAGE_PARAMETERS = (
    Float(
        "threshold",
        "Threshold",
        0.0,
        Span(0.0, 0.1, soft=0.01, digits=5),
        advanced=True,
        unit="weight of a cage vertex",
    ).described(
        "Speed up large cages by letting each point follow only the near part of the cage; 0 "
        "keeps all weights"
    ),
    stored_precision("the weights"),
    *SMOOTH,
)

OUTSIDE_REFUSED = Choice("outside", "Outside", "error", _REFUSED).described(
    "Choose what happens to vertices outside the cage"
)

QUALITIES = items(
    fast="Some hundredths of a second for 150 faces; errors of the weights up to 1/50",
    medium="Some tenths of a second for 150 faces; errors of the weights up to 1/200",
    fine="A second or two for 150 faces",
    finest="A minute and a gigabyte of memory; for comparisons",
)


def _positive_seconds(points: int, faces: int, options: Mapping[str, Any]) -> float:
    """Faces that hide each other are clipped, or rays are sent."""
    if options["exact"]:
        return 6e-9 * points * faces**1.5
    return (1.4e-7 + 1.6e-10 * options["directions"]) * points * faces


# Seconds by quality: for the boundary of a cage, for a lattice, and for each of its faces on the lattice.
_HARMONIC = {
    "fast": (0.03, 2.0, 0.0012),
    "medium": (0.35, 6.0, 0.0064),
    "fine": (1.5, 25.0, 0.025),
    "finest": (60.0, 80.0, 0.08),
}
_LATTICE_FROM = 600  # triangles


def _harmonic_seconds(points: int, faces: int, options: Mapping[str, Any]) -> float:
    """The boundary of the cage is solved once; a large cage is solved on a lattice instead."""
    boundary, lattice, face = _HARMONIC[options["quality"]]
    solved = boundary + 2e-9 * faces**3 if faces <= _LATTICE_FROM else lattice + face * faces
    return solved + 6e-8 * points * faces


def _green_seconds(points: int, faces: int, options: Mapping[str, Any]) -> float:
    """A quad has no closed form, and takes several times as long as its two triangles."""
    return (4e-8 if options["faces"] == "quads" else 1.4e-8) * points * faces


ROWS = (
    Method(
        id="mean_value",
        number=3,
        label="Quick Cage",
        known_as="Mean Value Cage",
        search="cage wrap mesh deform",
        family=Family.SPACE_LINEAR,
        section="5.4",
        paper="Ju, Schaefer & Warren 2005; Floater 2003",
        summary="Follows a coarse mesh around it at once; limbs side by side pull at each other",
        fails="Lets limbs side by side pull at each other",
        picture="coordinates",
        bind_seconds=_on_smooth(per_pair(1e-8)),
        reproduces=Reproduced.AFFINE_MAPS,
        takes_flat=True,
        **_CAGE,
        main=("smooth",),
        parameters=CAGE_PARAMETERS,
    ),
    Method(
        id="positive_mean_value",
        number=4,
        label="Split Cage",
        known_as="Positive Mean Value Cage",
        search="cage legs fingers apart",
        family=Family.SPACE_LINEAR,
        section="5.4",
        paper="Lipman, Kopf, Cohen-Or & Levin 2007",
        summary="Follows only the part of the cage it can see, so legs do not pull at each other",
        fails="Shows creases where sight of the cage ends",
        picture="coordinates",
        also_needs="which is closed and around everything",
        bind_seconds=_on_smooth(_positive_seconds),
        reproduces=Reproduced.AFFINE_MAPS,
        **_CAGE,
        main=("smooth",),
        parameters=(
            Bool("exact", "Exact", True).described(
                "Compute the weights exactly, instead of estimating them with rays: smoother, but slower"
            ),
            Int("directions", "Rays", 1024, Span(8, 65536, soft=4096), unit="rays per point").described(
                "Set the number of rays per point, if the weights are not exact"
            ),
            OUTSIDE_REFUSED,
            *CAGE_PARAMETERS,
        ),
    ),
    Method(
        id="harmonic",
        number=5,
        label="Limb Cage",
        known_as="Harmonic Cage",
        search="cage character pixar smooth",
        family=Family.SPACE_LINEAR,
        section="5.4",
        paper="Joshi, Meyer, DeRose, Green & Sanocki 2007",
        summary="Follows the cage along limbs and never across gaps; takes seconds to bind",
        fails="Refuses vertices outside the cage, and takes long to bind",
        picture="coordinates",
        also_needs="which is closed and around everything",
        bind_seconds=_on_smooth(_harmonic_seconds),
        reproduces=Reproduced.AFFINE_MAPS,
        **_CAGE,
        main=("quality", "smooth"),
        parameters=(
            Choice("quality", "Quality", "medium", QUALITIES).described(
                "Set how exactly the weights are computed at bind"
            ),
            OUTSIDE_REFUSED,
            *CAGE_PARAMETERS,
        ),
    ),
    Method(
        id="green",
        number=6,
        label="Detail Cage",
        known_as="Green Cage",
        search="cage details shape",
        family=Family.SPACE_LINEAR,
        section="5.4",
        paper="Lipman, Levin & Cohen-Or 2008; Thiery & Boubekeur 2022",
        summary="Follows the cage and keeps details in shape; bulges a little out of it",
        fails="Bulges out of the cage",
        picture="coordinates",
        also_needs="which is closed",
        bind_seconds=_on_smooth(_green_seconds),
        reproduces=Reproduced.SIMILARITIES,
        takes_flat=True,
        **_CAGE,
        main=("faces", "smooth"),
        parameters=(
            Choice("outside", "Outside", "nearest", _OUTSIDE).described(
                "Choose what happens to vertices outside the cage"
            ),
            Choice("faces", "Quads", "triangles", _FACES).described(
                "Choose what the faces of the cage with four corners are"
            ),
            *CAGE_PARAMETERS,
        ),
    ),
)
