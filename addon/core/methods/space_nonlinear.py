# SPDX-License-Identifier: GPL-3.0-or-later
"""Nonlinear space methods: an energy of the space around a shape decides where its points go."""

from collections.abc import Mapping
from typing import Any

from .schema import Family, Float, Int, Method, Moved, Posed, Reproduced, iterations, tolerance

_ITERATIONS = iterations(
    40,
    maximum=1000,
    rebinds=True,
    unit="iterations per frame",
    description="Limit the iterations of a frame; fewer are taken where the shape no longer changes",
)
_TOLERANCE = tolerance(
    soft_maximum=0.01,
    rebinds=True,
    description="Stop when two iterations in a row lower the energy by a smaller share",
)


def _graph_seconds(points: int, size: int, options: Mapping[str, Any]) -> float:
    """Fronts from each node, and the pulls of the handles."""
    return 4e-6 * points + 1e-8 * points * options["nodes"] ** 0.5 + 2e-5 * size + 1e-4 * options["nodes"]


def _cells_seconds(points: int, size: int, options: Mapping[str, Any]) -> float:
    """The shape is filled some times until the number of cells fits."""
    return 7e-6 * points + 2e-7 * size + 2.5e-5 * options["cells"]


ROWS = (
    Method(
        id="embedded_deformation",
        number=44,
        label="Scan Points",
        known_as="Embedded Deformation",
        search="scan cloud messy graph",
        family=Family.SPACE_NONLINEAR,
        native="EmbeddedDeformation",
        section="7",
        paper="Sumner, Schmid & Pauly 2007",
        summary="Bends torn scans and clouds of many parts",
        fails="Flattens hollow tubes where they bend",
        picture="embedded_deformation",
        main=("nodes",),
        draws="GRAPH",
        moves=frozenset(Moved),
        posed=Posed.POSES,
        moves_incoming=True,
        bind_seconds=_graph_seconds,
        reproduces=Reproduced.RIGID_MOTIONS,
        symmetric=False,
        parameters=(
            Int(
                "nodes",
                300,
                minimum=1,
                maximum=5000,
                soft_maximum=1000,
                rebinds=True,
                unit="nodes of the graph",
                label="Nodes",
                description="Set how many nodes the graph has; more of them bend finer, and take longer",
            ),
            Float(
                "rotation",
                1.0,
                minimum=1e-6,
                maximum=1e6,
                soft_maximum=100.0,
                rebinds=True,
                advanced=True,
                unit="weight",
                label="Rigidity",
                description="Set how strongly nodes only turn, instead of stretching and shearing",
            ),
            Float(
                "regularity",
                10.0,
                minimum=1e-6,
                maximum=1e6,
                soft_maximum=1000.0,
                rebinds=True,
                advanced=True,
                unit="weight",
                label="Smoothness",
                description="Set how strongly neighbouring nodes move alike",
            ),
            Float(
                "pulls",
                100.0,
                minimum=1e-6,
                maximum=1e6,
                soft_maximum=10000.0,
                rebinds=True,
                unit="weight",
                label="Strength",
                description="Set how strongly handles pull the nodes around them; higher values come "
                "closer to the handles, and let the shape stretch more",
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
        native="RigidCells",
        section="7",
        paper="Botsch, Pauly, Wicke & Gross 2007",
        summary="Bends anything like a solid body",
        fails="Stretches most right beside the handles",
        picture="rigid_cells",
        main=("cells",),
        draws="GRAPH",
        moves=frozenset(Moved),
        posed=Posed.POSES,
        finer="cells",
        bind_seconds=_cells_seconds,
        reproduces=Reproduced.RIGID_MOTIONS,
        symmetric=False,
        parameters=(
            Int(
                "cells",
                2000,
                minimum=8,
                maximum=100_000,
                soft_maximum=10_000,
                rebinds=True,
                unit="cells",
                label="Cells",
                description="Keep thinner parts apart by more cubes that fill the shape, which take longer",
            ),
            Int(
                "levels",
                2,
                minimum=0,
                maximum=6,
                soft_maximum=4,
                rebinds=True,
                advanced=True,
                unit="doublings",
                label="Coarsening",
                description="Save time inside closed surfaces, where cells may double their size so many "
                "times",
            ),
            _ITERATIONS,
            _TOLERANCE,
        ),
    ),
)
