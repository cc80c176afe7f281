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
    UvMap,
    factorising,
    laplacian,
)

CONTINUITY = Float(
    "continuity",
    2.0,
    maximum=2.0,
    soft_maximum=2.0,
    precision=1,
    step=0.1,
    rebinds=True,
    unit="derivatives kept",
    label="Continuity",
    description="How smoothly the surface leaves this region: 0 allows a crease, 1 keeps the slope, "
    "2 keeps the curvature",
)

FIELD = Choice(
    "field",
    "harmonic",
    (
        (
            "harmonic",
            "Harmonic",
            "As heat spreads from the handles: smooth everywhere, and quick to bind",
        ),
        ("geodesic", "Geodesic", "By the distances from the handles along the surface"),
        ("euclidean", "Euclidean", "By the straight distances from the handles, across gaps"),
    ),
    rebinds=True,
    label="Falloff",
    description="How the turn of a handle fades over the surface towards the other regions",
)


def _substeps(which: str, only_with: tuple[str, tuple[str, ...]] | None = None) -> Int:
    return Int(
        "substeps",
        1,
        minimum=1,
        maximum=1000,
        soft_maximum=16,
        advanced=True,
        only_with=only_with,
        unit="steps",
        label="Substeps",
        description="In how many steps the handles go from rest to their poses. " + which,
    )


def _laplacian_bind_seconds(points: int, size: int, options: Mapping[str, Any]) -> float:
    return factorising(0.7 if options["transforms"] == "implicit" else 0.05)(points, size, options)


def _spline_bind_seconds(points: int, size: int, options: Mapping[str, Any]) -> float:
    grid = int(options["columns"] * options["rows"])
    return (
        factorising(0.02)(points, size, options) + (5e-9 if options["smoothing"] == 0.0 else 2e-10) * grid**3
    )


ROWS = (
    Method(
        id="thin_shell",
        number=1,
        label="Thin Shell",
        family=Family.SURFACE_LINEAR,
        native="ThinShell",
        section="4.3",
        paper="Botsch & Kobbelt 2004",
        summary="Smooth and fair; best for translations and gentle bends",
        bind_seconds=factorising(0.035),
        handle_parameters=(CONTINUITY,),
        parameters=(
            Float(
                "stretching",
                0.0,
                soft_maximum=1.0,
                paintable=True,
                rebinds=True,
                unit="relative weight",
                label="Stretching",
                description="k_s: how much the surface resists being stretched, like a rubber skin. "
                "Raise it for a tighter, straighter transition",
            ),
            Float(
                "bending",
                1.0,
                soft_maximum=1.0,
                paintable=True,
                rebinds=True,
                unit="relative weight",
                label="Bending",
                description="k_b: how much the surface resists being bent, like a thin plate. "
                "It keeps the transition smooth at the border of a handle",
            ),
            Float(
                "variation",
                0.0,
                soft_maximum=1.0,
                paintable=True,
                rebinds=True,
                unit="relative weight",
                label="Variation",
                description="How much the surface resists a change of its curvature. "
                "It gives the roundest shapes, and needs wider handles",
            ),
            laplacian(),
            _substeps(
                "Each step binds the shape of the last one, so a frame takes as many binds. "
                "More steps keep twists from collapsing, and stretch bends",
            ),
        ),
    ),
    Method(
        id="gradient_editing",
        number=7,
        label="Gradient Editing",
        family=Family.SURFACE_LINEAR,
        native="GradientEditing",
        section="4.5.1",
        paper="Yu et al. 2004, Zayer et al. 2005",
        summary="Turns details with the handles, in bends and twists; handles that only move shear them",
        bind_seconds=factorising(0.03),
        reproduces=Reproduced.AFFINE_MAPS,
        parameters=(FIELD,),
    ),
    Method(
        id="rotation_invariant_coordinates",
        number=8,
        label="Rotation-Invariant Coordinates",
        family=Family.SURFACE_LINEAR,
        native="RotationInvariantCoordinates",
        section="4.5.3",
        paper="Lipman et al. 2005, 2007",
        summary="Keeps details unstretched in bends and twists; handles that only move shear them",
        bind_seconds=factorising(0.03),
        reproduces=Reproduced.RIGID_MOTIONS,
        parameters=(laplacian("cotan", choices=2),),
    ),
    Method(
        id="propagation",
        number=9,
        label="Transformation Propagation",
        family=Family.SURFACE_LINEAR,
        native="Propagation",
        section="4.2",
        paper="Bendels & Klein 2003, Pauly et al. 2003",
        summary="Lets the motion of a handle fade over the surface by a curve: quick, and never stiff",
        bind_seconds=factorising(0.03),
        reproduces=Reproduced.AFFINE_MAPS,
        parameters=(
            FIELD,
            Curve(
                "transfer",
                ((0.0, 0.0), (1.0, 1.0)),
                rebinds=True,
                label="Falloff Curve",
                description="How much of the motion of a handle is left, from the other regions (left) "
                "to the handle itself (right)",
            ),
        ),
    ),
    Method(
        id="laplacian_editing",
        number=10,
        label="Laplacian Editing",
        family=Family.SURFACE_LINEAR,
        native="LaplacianEditing",
        section="4.5.2",
        paper="Lipman et al. 2004, Sorkine et al. 2004",
        summary="Smooth like the thin shell, and turns details where handles turn or move",
        bind_seconds=_laplacian_bind_seconds,
        parameters=(
            Choice(
                "transforms",
                "estimated",
                (
                    ("none", "None", "Details keep their directions, as in the thin shell"),
                    (
                        "explicit",
                        "From Handles",
                        "Details turn as the handles do, and the turn fades by the falloff",
                    ),
                    ("estimated", "Estimated", "Details turn as their neighbourhoods do in a first solution"),
                    (
                        "implicit",
                        "Implicit",
                        "Details turn as their neighbourhoods do, found together with their places. "
                        "Takes about 20 times as long to bind",
                    ),
                ),
                rebinds=True,
                label="Details",
                description="How the details of the surface are turned",
            ),
            replace(FIELD, only_with=("transforms", ("explicit",))),
            Int(
                "refits",
                2,
                maximum=64,
                soft_maximum=16,
                rebinds=True,
                unit="solves",
                only_with=("transforms", ("estimated",)),
                label="Refits",
                description="Of Estimated: how often the turns are estimated again from the last solution. "
                "Each costs as much as a thin shell",
            ),
            Choice(
                "second_stage",
                "polar",
                (
                    (
                        "polar",
                        "Rotation",
                        "Turns the details, each by the rotation nearest to its transformation",
                    ),
                    (
                        "length",
                        "Length",
                        "Transforms the details and restores their lengths, as the paper does",
                    ),
                ),
                rebinds=True,
                advanced=True,
                only_with=("transforms", ("implicit",)),
                label="Second Stage",
                description="Of Implicit: what is done with the transformations",
            ),
            Bool(
                "mean_frame",
                True,
                rebinds=True,
                advanced=True,
                only_with=("transforms", ("estimated", "implicit")),
                label="Mean Frame",
                description="Of Estimated and Implicit: sees the handles from the mean of their turns, "
                "so that each of two handles turns by half of the angle between them",
            ),
            laplacian(),
            _substeps(
                "Of Estimated: each step starts from the shape of the last one. Of None and Implicit: each "
                "step binds it, so a frame takes as many binds. Helps where two handles twist the surface",
                only_with=("transforms", ("none", "estimated", "implicit")),
            ),
        ),
    ),
    Method(
        id="hierarchical_smoothing",
        number=11,
        label="Hierarchical Smoothing",
        family=Family.SURFACE_LINEAR,
        native="HierarchicalSmoothing",
        section="4.3",
        paper="Guskov, Sweldens & Schröder 1999",
        summary="Smooth between the handles, and details of every size turn with the coarser shape",
        bind_seconds=factorising(0.08),
        reproduces=Reproduced.RIGID_MOTIONS,
        symmetric=False,
        parameters=(
            Int(
                "levels",
                64,
                maximum=1000,
                soft_maximum=100,
                rebinds=True,
                unit="levels",
                label="Levels",
                description="How often the surface between the regions is thinned out, at most. "
                "With few levels, only fine details turn",
            ),
            Int(
                "relaxations",
                4,
                maximum=1000,
                soft_maximum=32,
                rebinds=True,
                unit="sweeps",
                label="Relaxations",
                description="How often each level is smoothed. More make the transition at the border "
                "of a region rounder, and take longer",
            ),
        ),
    ),
    Method(
        id="spline_surface",
        number=14,
        label="Spline Surface",
        family=Family.SURFACE_LINEAR,
        native="SplineSurface",
        section="4.1",
        paper="Farin 1997",
        summary="Displaces the surface by a grid of smooth bumps over a UV map or a plane; best for sheets",
        draws="GRID",
        bind_seconds=_spline_bind_seconds,
        parameters=(
            Int(
                "degree",
                3,
                minimum=1,
                maximum=5,
                soft_maximum=5,
                rebinds=True,
                unit="polynomial degree",
                label="Degree",
                description="1 joins straight pieces with creases; a higher degree is smoother, and each "
                "control point moves a larger rectangle",
            ),
            Int(
                "columns",
                8,
                minimum=2,
                maximum=32,
                soft_maximum=32,
                rebinds=True,
                unit="control points",
                label="Columns",
                description="Control points along the longer side of the plane, or along u of the UV map; "
                "at least one more than the degree",
            ),
            Int(
                "rows",
                8,
                minimum=2,
                maximum=32,
                soft_maximum=32,
                rebinds=True,
                unit="control points",
                label="Rows",
                description="Control points across it, or along v of the UV map; at least one more than the "
                "degree",
            ),
            GridPoints(
                "grid",
                label="Grid Object",
                description="The mesh whose points move those of the control grid, which New Grid makes; if "
                "empty, the regions alone move them",
            ),
            UvMap(
                "uv_map",
                rebinds=True,
                label="UV Map",
                description="Where the grid lies; if empty, on the plane that fits the surface best",
            ),
            Float(
                "smoothing",
                1e-3,
                soft_maximum=1.0,
                precision=4,
                step=0.001,
                rebinds=True,
                unit="relative weight",
                label="Smoothing",
                description="How much the control grid resists being bent. With 0 it follows the regions by "
                "least squares alone, and may overshoot",
            ),
            Float(
                "margin",
                0.2,
                soft_maximum=1.0,
                rebinds=True,
                advanced=True,
                unit="share of the size",
                label="Margin",
                description="How far the grid reaches into handles and fixed regions, as a share of the size "
                "of the free surface. More makes the surface leave them more smoothly",
            ),
        ),
    ),
    Method(
        id="volumetric_graph_laplacian",
        number=12,
        label="Volumetric Graph Laplacian",
        family=Family.SURFACE_LINEAR,
        native="VolumetricGraphLaplacian",
        section="4.5.2",
        paper="Zhou et al. 2005",
        summary="Laplacian editing with a graph of points inside, so that bends keep more of the volume",
        bind_seconds=factorising(0.3),
        reproduces=Reproduced.AFFINE_MAPS,
        symmetric=False,
        parameters=(
            Float(
                "volume",
                1.0,
                soft_maximum=10.0,
                rebinds=True,
                unit="relative weight",
                label="Volume",
                description="How much the points inside count beside the surface. 0 leaves the surface alone",
            ),
            laplacian(),
        ),
    ),
    Method(
        id="subdivision_editing",
        number=13,
        label="Subdivision Editing",
        family=Family.SURFACE_LINEAR,
        native="SubdivisionEditing",
        section="4.3",
        paper="Zorin, Schröder & Sweldens 1997",
        summary="Edits any level of a subdivided mesh, and keeps what was sculpted on the finer ones",
        bind_seconds=factorising(0.025),
        reproduces=Reproduced.RIGID_MOTIONS,
        parameters=(
            Choice(
                "coarsening",
                "automatic",
                (
                    (
                        "automatic",
                        "Automatic",
                        "Undoes subdivision as often as each loose part keeps 64 vertices",
                    ),
                    ("levels", "Levels", "Undoes subdivision as often as Levels says"),
                ),
                rebinds=True,
                label="Coarsening",
                description="On which level of the subdivided mesh the handles pull. Coarse levels carry "
                "large details, which then turn with the surface; fine ones follow the handles more closely",
            ),
            Int(
                "levels",
                1,
                maximum=1000,
                soft_maximum=6,
                rebinds=True,
                unit="levels",
                only_with=("coarsening", ("levels",)),
                label="Levels",
                description="How often subdivision is undone, where the mesh has so many levels. "
                "0 bends the mesh itself as a plate",
            ),
        ),
    ),
)
