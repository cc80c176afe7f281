# SPDX-License-Identifier: GPL-3.0-or-later
"""Linear surface methods: one sparse system per frame."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from .schema import (
    Bool,
    Choice,
    Curve,
    Family,
    Float,
    GridPoints,
    Int,
    Method,
    Reproduced,
    Span,
    UvMap,
    factorising,
    items,
    laplacian,
    solver,
)


def _substeps(which: str, only_with: tuple[str, tuple[str, ...]] | None = None) -> Int:
    return Int(
        "substeps",
        "Substeps",
        1,
        Span(1, 1000, soft=16),
        rebinds=False,
        advanced=True,
        only_with=only_with,
        unit="steps",
    ).described("Take the handles from rest to their poses in so many steps; " + which)


def _laplacian_bind_seconds(points: int, size: int, options: Mapping[str, Any]) -> float:
    return factorising(0.7 if options["transforms"] == "implicit" else 0.05)(points, size, options)


def _spline_bind_seconds(points: int, size: int, options: Mapping[str, Any]) -> float:
    grid = int(options["columns"] * options["rows"])
    return (
        factorising(0.02)(points, size, options) + (5e-9 if options["smoothing"] == 0.0 else 2e-10) * grid**3
    )


_FIELDS = items(
    harmonic="As heat spreads from the handles: smooth everywhere, and quick to bind",
    geodesic="By the distances from the handles along the surface",
    euclidean="By the straight distances from the handles, across gaps",
)

_TRANSFORMS = items(
    none="Details keep their directions, as in the thin shell",
    explicit=("From Handles", "Details turn as the handles do, and the turn fades by the falloff"),
    estimated="Details turn as their neighbourhoods do in a first solution",
    implicit="Details turn as their neighbourhoods do, found together with their places; takes "
    "about 20 times as long to bind",
)

_SECOND_STAGES = items(
    polar=("Rotation", "Turns the details, each by the rotation nearest to its transformation"),
    length="Transforms the details and restores their lengths",
)

_COARSENINGS = items(
    automatic="Undoes subdivision as often as each loose part keeps 64 vertices",
    levels="Undoes subdivision as often as Levels says",
)


CONTINUITY = Float(
    "continuity", "Continuity", 2.0, Span(0.0, 2.0, soft=2.0, digits=1, step=0.1), unit="derivatives kept"
).described(
    "Set how smoothly the surface leaves this region: 0 allows a crease, 1 keeps the slope, 2 "
    "keeps the curvature"
)

FIELD = Choice("field", "Falloff", "harmonic", _FIELDS).described(
    "Set how the turn of a handle fades over the surface towards the other regions"
)


ROWS = (
    Method(
        id="thin_shell",
        number=1,
        label="Soft Sheet",
        known_as="Thin Shell",
        search="cloth flag leaf smooth relax membrane",
        family=Family.SURFACE_LINEAR,
        section="4.3",
        paper="Botsch & Kobbelt 2004",
        summary="Lifts and bends cloth, leaves and skin as softly as can be",
        fails="Collapses in twists and tight bends",
        picture="gallery: plane",
        bind_seconds=factorising(0.035),
        main=("stretching", "bending"),
        handle_parameters=(CONTINUITY,),
        parameters=(
            Float(
                "stretching", "Stretching", 0.0, Span(soft=1.0), paintable=True, unit="relative weight"
            ).described(
                "Tighten the surface like a rubber skin, so that it goes straighter from one "
                "region to the other"
            ),
            Float(
                "bending", "Bending", 1.0, Span(soft=1.0), paintable=True, unit="relative weight"
            ).described("Stiffen the surface like a thin plate, so that it leaves handles smoothly"),
            Float(
                "variation", "Variation", 0.0, Span(soft=1.0), paintable=True, unit="relative weight"
            ).described(
                "Round the surface most by resisting changes of its curvature, which needs wider handles"
            ),
            laplacian(),
            _substeps("more steps keep twists from collapsing, and a frame takes as many binds"),
            solver("Takes a fifth of the memory and binds quickly, but frames are slow"),
        ),
    ),
    Method(
        id="gradient_editing",
        number=7,
        label="Turned Bend",
        known_as="Gradient Editing",
        search="twist turn poisson gradient",
        family=Family.SURFACE_LINEAR,
        section="4.5.1",
        paper="Yu et al. 2004, Zayer et al. 2005, Shi et al. 2006",
        summary="Spreads the turn of a handle evenly; handles have to turn, not only move",
        fails="Shears the surface beside handles that only move",
        picture="gallery: cylinder",
        bind_seconds=factorising(0.03),
        reproduces=Reproduced.AFFINE_MAPS,
        main=("field",),
        parameters=(FIELD, solver("Binds in less time, but frames are slow")),
    ),
    Method(
        id="rotation_invariant_coordinates",
        number=8,
        label="Even Bend",
        known_as="Rotation-Invariant Coordinates",
        search="twist even unstretched",
        family=Family.SURFACE_LINEAR,
        section="4.5.3",
        paper="Lipman et al. 2005, 2007",
        summary="Twists and bends with little stretch; handles have to turn, not only move",
        fails="Shears the surface beside handles that only move",
        picture="gallery: bar",
        bind_seconds=factorising(0.03),
        reproduces=Reproduced.RIGID_MOTIONS,
        parameters=(laplacian("cotan", choices=2),),
    ),
    Method(
        id="propagation",
        number=9,
        label="Falloff Sheet",
        known_as="Transformation Propagation",
        search="proportional soft selection softmod magnet falloff",
        family=Family.SURFACE_LINEAR,
        section="4.2",
        paper="Bendels & Klein 2003, Pauly et al. 2003",
        summary="Lets a move fade over the surface by a curve that you draw",
        fails="Keeps nothing stiff",
        picture="gallery: branches",
        bind_seconds=factorising(0.03),
        reproduces=Reproduced.AFFINE_MAPS,
        main=("field",),
        parameters=(
            FIELD,
            Curve("transfer", "Falloff Curve", ((0.0, 0.0), (1.0, 1.0))).described(
                "Draw how much of the motion of a handle is left, from the other regions "
                "(left) to the handle itself (right)"
            ),
        ),
    ),
    Method(
        id="laplacian_editing",
        number=10,
        label="Smooth Bend",
        known_as="Laplacian Editing",
        search="laplacian deform smooth",
        family=Family.SURFACE_LINEAR,
        section="4.5.2",
        paper="Lipman et al. 2004, Sorkine et al. 2004",
        summary="Moves a bumpy surface smoothly, and turns its bumps",
        fails="Flattens what is twisted by more than a right angle",
        picture="gallery: plane",
        bind_seconds=_laplacian_bind_seconds,
        main=("transforms",),
        parameters=(
            Choice("transforms", "Details", "estimated", _TRANSFORMS).described(
                "Set how the details of the surface are turned"
            ),
            replace(FIELD, only_with=("transforms", ("explicit",))),
            Int(
                "refits",
                "Refits",
                2,
                Span(0, 64, soft=16),
                only_with=("transforms", ("estimated",)),
                unit="solves",
            ).described("Bring twists closer to rigid by estimating the turns so many times again"),
            Choice(
                "second_stage",
                "Second Stage",
                "polar",
                _SECOND_STAGES,
                advanced=True,
                only_with=("transforms", ("implicit",)),
            ).described("Keep the size of details by what is done with how they are found to turn and grow"),
            Bool(
                "mean_frame",
                "Mean Frame",
                True,
                advanced=True,
                only_with=("transforms", ("estimated", "implicit")),
            ).described("Improve large turns by looking from the middle of the turns of all handles"),
            laplacian(),
            _substeps(
                "more steps help where two handles twist the surface, and may take as many binds",
                only_with=("transforms", ("none", "estimated", "implicit")),
            ),
        ),
    ),
    Method(
        id="hierarchical_smoothing",
        number=11,
        label="Layered Bend",
        known_as="Hierarchical Smoothing",
        search="levels multires hierarchical",
        family=Family.SURFACE_LINEAR,
        section="4.3",
        paper="Guskov, Sweldens & Schröder 1999",
        summary="Bends coarse and fine details level by level",
        fails="Bends symmetric meshes not quite symmetrically",
        picture="gallery: branches",
        bind_seconds=factorising(0.08),
        reproduces=Reproduced.RIGID_MOTIONS,
        symmetric=False,
        main=("levels",),
        parameters=(
            Int("levels", "Levels", 64, Span(0, 1000, soft=100), unit="levels").described(
                "Set how often the surface between the regions is thinned out, at most; with "
                "few levels, only fine details turn"
            ),
            Int("relaxations", "Relaxations", 4, Span(0, 1000, soft=32), unit="sweeps").described(
                "Round the way out of each region by smoothing each level more often, which takes longer"
            ),
        ),
    ),
    Method(
        id="spline_surface",
        number=14,
        label="Grid Sheet",
        known_as="Spline Surface",
        search="patch nurbs uv grid banner",
        family=Family.SURFACE_LINEAR,
        section="4.1",
        paper="Farin 1997",
        summary="Moves a sheet by a grid of smooth bumps on its UV map",
        fails="Moves front and back of closed bodies alike",
        picture="spline_surface",
        also_needs="best with a UV map",
        draws="GRID",
        bind_seconds=_spline_bind_seconds,
        main=("columns", "rows"),
        parameters=(
            Int("degree", "Degree", 3, Span(1, 5, soft=5), unit="polynomial degree").described(
                "Smooth the sheet by higher degrees, which reach farther; 1 joins straight "
                "pieces with creases"
            ),
            Int("columns", "Columns", 8, Span(2, 32, soft=32), unit="control points").described(
                "Set the control points along the longer side of the plane, or along u of the UV map"
            ),
            Int("rows", "Rows", 8, Span(2, 32, soft=32), unit="control points").described(
                "Set the control points across it, or along v of the UV map"
            ),
            GridPoints("grid", "Grid Object").described(
                "Choose the mesh whose points move those of the control grid; if empty, the "
                "regions alone move them"
            ),
            UvMap("uv_map", "UV Map").described(
                "Choose where the grid lies; if empty, on the plane that fits the surface best"
            ),
            Float(
                "smoothing", "Smoothing", 1e-3, Span(soft=1.0, digits=4, step=0.001), unit="relative weight"
            ).described("Calm the control grid, which overshoots with 0"),
            Float("margin", "Margin", 0.2, Span(soft=1.0), advanced=True, unit="share of the size").described(
                "Leave regions more smoothly by letting the grid reach into them, as a share "
                "of the size of the free surface"
            ),
        ),
    ),
    Method(
        id="volumetric_graph_laplacian",
        number=12,
        label="Filled Bend",
        known_as="Volumetric Graph Laplacian",
        search="volume inside stuffed",
        family=Family.SURFACE_LINEAR,
        section="4.5.2",
        paper="Zhou et al. 2005",
        summary="Bends as if the body were filled, so that it stays full",
        fails="Narrows what is twisted, and finds no inside in flat sheets",
        picture="volume",
        also_needs="best a closed one",
        bind_seconds=factorising(0.3),
        reproduces=Reproduced.AFFINE_MAPS,
        symmetric=False,
        main=("volume",),
        parameters=(
            Float("volume", "Volume", 1.0, Span(soft=10.0), unit="relative weight").described(
                "Set how much the points inside count beside the surface; 0 leaves the surface alone"
            ),
            laplacian(),
        ),
    ),
    Method(
        id="subdivision_editing",
        number=13,
        label="Sculpt Levels",
        known_as="Subdivision Editing",
        search="multires subdivision sculpt",
        family=Family.SURFACE_LINEAR,
        section="4.3",
        paper="Zorin, Schröder & Sweldens 1997",
        summary="Moves a coarse level of a subdivided mesh, and keeps the sculpt on the finer ones",
        fails="Finds no levels in a mesh that was not subdivided",
        picture="pillars",
        also_needs="which was subdivided",
        bind_seconds=factorising(0.045),
        reproduces=Reproduced.RIGID_MOTIONS,
        main=("levels",),
        parameters=(
            Choice("coarsening", "Coarsening", "automatic", _COARSENINGS).described(
                "Choose the level that handles pull: coarse ones turn large details along, "
                "fine ones follow more closely"
            ),
            Int(
                "levels",
                "Levels",
                1,
                Span(0, 1000, soft=6),
                only_with=("coarsening", ("levels",)),
                unit="levels",
            ).described(
                "Set how often subdivision is undone, where the mesh has so many levels; 0 "
                "bends the mesh itself as a plate"
            ),
        ),
    ),
)
