# SPDX-License-Identifier: GPL-3.0-or-later
"""Nonlinear surface methods: they minimise an energy, step by step, from a start."""

from .schema import Choice, Control, Family, Float, Int, Method, Moved, Reproduced, factorising

CELLS = (
    ("spokes", "Spokes", "Each vertex keeps the edges that meet it rigid"),
    (
        "rims",
        "Spokes and Rims",
        "Each vertex also keeps the edges opposite to it rigid: firmer, and more stable on thin triangles",
    ),
)


ROWS = (
    Method(
        id="arap",
        number=2,
        label="As-Rigid-As-Possible",
        family=Family.SURFACE_NONLINEAR,
        control=Control.HANDLES,
        native="Arap",
        section="6",
        paper="Sorkine & Alexa 2007, Levi & Gotsman 2015",
        summary="Keeps details through large turns; best for limbs",
        iterative=True,
        moves=frozenset({Moved.MESH}),
        bind_seconds=factorising(0.12),
        reproduces=Reproduced.RIGID_MOTIONS,
        parameters=(
            Float(
                "smoothness",
                5e-4,
                maximum=10.0,
                soft_maximum=0.01,
                precision=5,
                rebinds=True,
                unit="share of the rest area",
                label="Smooth Rotations",
                description="How much neighbouring parts rotate together, as a share of the surface's area. "
                "0 gives the energy of the paper, which buckles on fine meshes",
            ),
            Choice(
                "cells",
                "spokes",
                CELLS,
                rebinds=True,
                label="Cells",
                description="Which edges each vertex keeps rigid",
            ),
            Float(
                "rigidity",
                1.0,
                minimum=0.001,
                soft_maximum=1.0,
                paintable=True,
                rebinds=True,
                unit="relative weight",
                label="Rigidity",
                description="How firmly a region keeps its shape. "
                "Paint a vertex group to let soft parts deform more than hard ones",
            ),
            Int(
                "max_iterations",
                40,
                minimum=1,
                soft_maximum=100,
                unit="iterations",
                label="Iterations",
                description="The largest number of steps per frame. "
                "While you drag, fewer steps are computed; the others follow when you stop",
            ),
            Float(
                "tolerance",
                1e-4,
                maximum=1.0,
                soft_maximum=0.001,
                precision=6,
                unit="share of the energy",
                label="Tolerance",
                description="Stop when two steps in a row lower the energy by less than this share of it",
            ),
        ),
    ),
    Method(
        id="handle_aware_isolines",
        number=33,
        label="Handle-Aware Isolines",
        family=Family.SURFACE_NONLINEAR,
        control=Control.HANDLES,
        native="HandleAwareIsolines",
        section="6",
        paper="Au et al. 2007",
        summary="One rotation for each band between two handles: for few handles on heavy meshes",
        iterative=True,
        moves=frozenset({Moved.MESH}),
        bind_seconds=factorising(0.15),
        reproduces=Reproduced.RIGID_MOTIONS,
        parameters=(
            Int(
                "bands",
                24,
                minimum=2,
                maximum=1000,
                soft_maximum=64,
                rebinds=True,
                unit="bands between two handles",
                label="Bands",
                description="How many bands between two handles turn each as one. "
                "More of them bend more evenly, and take more memory and time",
            ),
            Choice(
                "field",
                "harmonic",
                (
                    ("harmonic", "Harmonic", "Isolines of a smooth field between the handles"),
                    ("geodesic", "Geodesic", "Isolines by distances along the surface"),
                ),
                rebinds=True,
                label="Isolines",
                description="What bounds the bands",
            ),
            Int(
                "max_iterations",
                200,
                minimum=1,
                soft_maximum=500,
                advanced=True,
                unit="turns",
                label="Turns",
                description="The largest number of times that the rotations are fitted per frame. "
                "Each takes some microseconds",
            ),
            Float(
                "tolerance",
                1e-6,
                maximum=1.0,
                soft_maximum=0.001,
                precision=7,
                advanced=True,
                unit="entry of a rotation",
                label="Tolerance",
                description="Stop when no entry of a rotation changes by more than this",
            ),
        ),
    ),
)
