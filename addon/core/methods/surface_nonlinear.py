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

MEASURES = (
    ("share", "Share of the Size", "Thickness is a share of the diagonal of the box around the rest shape"),
    ("length", "Length", "Thickness is a length"),
    ("stiffness", "Stretching and Bending", "Both stiffnesses are set by themselves"),
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
        id="thin_shell_nonlinear",
        number=24,
        label="Nonlinear Thin Shell",
        family=Family.SURFACE_NONLINEAR,
        control=Control.HANDLES,
        native="ThinShellNonlinear",
        section="4.3",
        paper="Terzopoulos et al. 1987",
        summary="Bends and stretches like a sheet of rubber with a thickness",
        iterative=True,
        moves=frozenset({Moved.MESH}),
        bind_seconds=factorising(0.3),
        reproduces=Reproduced.RIGID_MOTIONS,
        parameters=(
            Choice(
                "measure",
                "share",
                MEASURES,
                rebinds=True,
                label="Stiffness From",
                description="What says how stiff the sheet is",
            ),
            Float(
                "thickness",
                0.02,
                soft_maximum=0.1,
                precision=4,
                step=0.1,
                paintable=True,
                rebinds=True,
                only_with=("measure", ("share", "length")),
                unit="share of the size, or a length",
                label="Thickness",
                description="How thick the sheet is: a thin one bends like paper, a thick one stretches. "
                "Paint a vertex group to let thin parts fold",
            ),
            Float(
                "stretching",
                1.0,
                minimum=0.001,
                soft_maximum=10.0,
                paintable=True,
                rebinds=True,
                only_with=("measure", ("stiffness",)),
                unit="relative weight",
                label="Stretching",
                description="k_s: how much the sheet resists being stretched",
            ),
            Float(
                "bending",
                1.0,
                soft_maximum=10.0,
                precision=5,
                paintable=True,
                rebinds=True,
                only_with=("measure", ("stiffness",)),
                unit="area, times that of Stretching",
                label="Bending",
                description="k_b: how much the sheet resists being bent. The thickness is the square root of "
                "Bending by Stretching",
            ),
            Int(
                "max_iterations",
                60,
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
)
