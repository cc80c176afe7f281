# SPDX-License-Identifier: GPL-3.0-or-later
"""Linear space methods: each point is a weighted sum of what moves it."""

from .schema import Bool, Choice, Control, Family, Float, Int, Method, Moved

PRECISIONS = (
    ("single", "Single", "Half the memory and time of a frame; exact to a ten-millionth of the cage's size"),
    ("double", "Double", "As exact as the coordinates themselves"),
)

CAGE_PARAMETERS = (
    Float(
        "threshold",
        0.0,
        maximum=0.1,
        soft_maximum=0.01,
        precision=5,
        rebinds=True,
        advanced=True,
        unit="weight of a cage vertex",
        label="Sparse Threshold",
        description="Leave out smaller weights, so that each point follows the near part of the cage "
        "alone: faster, less exact. 0 keeps all",
    ),
    Choice(
        "precision",
        "single",
        PRECISIONS,
        rebinds=True,
        advanced=True,
        label="Precision",
        description="How exactly the weights are kept",
    ),
)

OUTSIDE_REFUSED = Choice(
    "outside",
    "error",
    (
        ("error", "Refuse", "Vertices outside the cage are named, and nothing moves until they are inside"),
        ("mean_value", "Mean Value", "Vertices outside the cage follow it by mean value coordinates"),
    ),
    rebinds=True,
    label="Outside",
    description="What becomes of vertices outside the cage",
)

QUALITIES = (
    ("fast", "Fast", "Some hundredths of a second for 150 faces; weights to a fiftieth"),
    ("medium", "Medium", "Some tenths of a second for 150 faces; weights to a two-hundredth"),
    ("fine", "Fine", "A second or two for 150 faces"),
    ("finest", "Finest", "A minute and a gigabyte; for references"),
)


ROWS = (
    Method(
        id="mean_value",
        number=3,
        label="Mean Value Cage",
        family=Family.SPACE_LINEAR,
        control=Control.CAGE,
        native="MeanValue",
        section="5.4",
        paper="Ju, Schaefer & Warren 2005",
        summary="Any points, inside the cage or outside; limbs that lie side by side pull at each other",
        iterative=False,
        moves=frozenset(Moved),
        parameters=CAGE_PARAMETERS,
    ),
    Method(
        id="positive_mean_value",
        number=4,
        label="Positive Mean Value Cage",
        family=Family.SPACE_LINEAR,
        control=Control.CAGE,
        native="PositiveMeanValue",
        section="5.4",
        paper="Lipman, Kopf, Cohen-Or & Levin 2007",
        summary="Each point follows what it sees of the cage, so limbs do not pull at each other",
        iterative=False,
        moves=frozenset(Moved),
        parameters=(
            Bool(
                "exact",
                True,
                rebinds=True,
                label="Exact",
                description="Off, what is seen is guessed by rays: a quicker preview that is a little rough",
            ),
            Int(
                "directions",
                1024,
                minimum=8,
                maximum=65536,
                soft_maximum=4096,
                rebinds=True,
                unit="rays per point",
                label="Rays",
                description="How many rays a point has where the weights are not exact",
            ),
            OUTSIDE_REFUSED,
            *CAGE_PARAMETERS,
        ),
    ),
    Method(
        id="harmonic",
        number=5,
        label="Harmonic Cage",
        family=Family.SPACE_LINEAR,
        control=Control.CAGE,
        native="Harmonic",
        section="5.4",
        paper="Joshi, Meyer, DeRose, Green & Sanocki 2007",
        summary="Influence flows inside the cage, along limbs and never across gaps; smooth inside",
        iterative=False,
        moves=frozenset(Moved),
        parameters=(
            Choice(
                "quality",
                "medium",
                QUALITIES,
                rebinds=True,
                label="Quality",
                description="How exactly the weights are computed, once, at bind",
            ),
            OUTSIDE_REFUSED,
            *CAGE_PARAMETERS,
        ),
    ),
    Method(
        id="green",
        number=6,
        label="Green Cage",
        family=Family.SPACE_LINEAR,
        control=Control.CAGE,
        native="Green",
        section="5.4",
        paper="Lipman, Levin & Cohen-Or 2008",
        summary="Keeps shapes: parts turn instead of shearing, and bulge out of the cage a little",
        iterative=False,
        moves=frozenset(Moved),
        parameters=(
            Choice(
                "outside",
                "nearest",
                (
                    ("nearest", "Nearest Face", "Each vertex outside follows through the nearest face"),
                    (
                        "error",
                        "Refuse",
                        "Vertices outside are named, and nothing moves until they are inside",
                    ),
                ),
                rebinds=True,
                label="Outside",
                description="What becomes of vertices outside the cage",
            ),
            *CAGE_PARAMETERS,
        ),
    ),
)
