# SPDX-License-Identifier: GPL-3.0-or-later
"""Nonlinear space methods: an energy of the space around a shape decides where its points go."""

from collections.abc import Mapping
from typing import Any

from .schema import Family, Float, Int, Method, Moved, Posed, Reproduced, Span, iterations, tolerance

_ITERATIONS = iterations(
    40,
    maximum=1000,
    rebinds=True,
    unit="iterations per frame",
    description="Limit the iterations of a frame; fewer are taken where the shape no longer changes",
)
_TOLERANCE = tolerance(
    soft=0.01,
    rebinds=True,
    description="Stop when two iterations in a row lower the energy by a smaller share",
)


def _graph_seconds(points: int, size: int, options: Mapping[str, Any]) -> float:
    """Fronts from each node, and the pulls of the handles."""
    return 4e-6 * points + 1e-8 * points * options["nodes"] ** 0.5 + 2e-5 * size + 1e-4 * options["nodes"]


def _cells_seconds(points: int, size: int, options: Mapping[str, Any]) -> float:
    """The shape is filled some times until the number of cells fits."""
    return 7e-6 * points + 2e-7 * size + 2.5e-5 * options["cells"]


_FILLED: dict[str, Any] = {
    "draws": "GRAPH",
    "moves": frozenset(Moved),
    "posed": Posed.POSES,
    "reproduces": Reproduced.RIGID_MOTIONS,
    "symmetric": False,
}

ROWS = (
    Method(
        id="embedded_deformation",
        number=44,
        label="Scan Points",
        known_as="Embedded Deformation",
        search="scan cloud messy graph",
        family=Family.SPACE_NONLINEAR,
        section="7",
        paper="Sumner, Schmid & Pauly 2007",
        summary="Bends torn scans and clouds of many parts",
        fails="Flattens hollow tubes where they bend",
        picture="embedded_deformation",
        moves_incoming=True,
        bind_seconds=_graph_seconds,
        **_FILLED,
        main=("nodes",),
        parameters=(
            Int("nodes", "Nodes", 300, Span(1, 5000, soft=1000), unit="nodes of the graph").described(
                "Set how many nodes the graph has; more of them bend finer, and take longer"
            ),
            Float(
                "rotation", "Rigidity", 1.0, Span(1e-6, 1e6, soft=100.0), advanced=True, unit="weight"
            ).described("Set how strongly nodes only turn, instead of stretching and shearing"),
            Float(
                "regularity", "Smoothness", 10.0, Span(1e-6, 1e6, soft=1000.0), advanced=True, unit="weight"
            ).described("Set how strongly neighbouring nodes move alike"),
            Float("pulls", "Strength", 100.0, Span(1e-6, 1e6, soft=10000.0), unit="weight").described(
                "Set how strongly handles pull the nodes around them; higher values come "
                "closer to the handles, and let the shape stretch more"
            ),
            _ITERATIONS,
            _TOLERANCE,
        ),
    ),
    Method(
        id="rigid_cells",
        number=45,
        label="Solid Points",
        known_as="Rigid Cells",
        search="solid jelly volume cells",
        family=Family.SPACE_NONLINEAR,
        section="7",
        paper="Botsch, Pauly, Wicke & Gross 2007",
        summary="Bends anything like a solid body",
        fails="Stretches most right beside the handles",
        picture="rigid_cells",
        finer="cells",
        bind_seconds=_cells_seconds,
        **_FILLED,
        main=("cells",),
        parameters=(
            Int("cells", "Cells", 2000, Span(8, 100_000, soft=10_000), unit="cells").described(
                "Keep thinner parts apart by more cubes that fill the shape, which take longer"
            ),
            Int("levels", "Coarsening", 2, Span(0, 6, soft=4), advanced=True, unit="doublings").described(
                "Save time inside closed surfaces, where cells may double their size so many times"
            ),
            _ITERATIONS,
            _TOLERANCE,
        ),
    ),
)
