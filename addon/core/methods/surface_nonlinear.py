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
        id="mesh_puppetry",
        number=29,
        label="Mesh Puppetry",
        family=Family.SURFACE_NONLINEAR,
        control=Control.HANDLES,
        native="MeshPuppetry",
        section="6",
        paper="Shi et al. 2007",
        summary="The skin of bones: limbs stay rigid and joints bend between them; best for figures",
        iterative=True,
        moves=frozenset({Moved.MESH}),
        bind_seconds=factorising(0.2),
        reproduces=Reproduced.RIGID_MOTIONS,
        parameters=(
            Float(
                "bending",
                1e-3,
                maximum=10.0,
                soft_maximum=0.1,
                precision=5,
                rebinds=True,
                unit="share of the rest area",
                label="Bending",
                description="How much bends and bumps of the surface are kept, beside the lengths of its "
                "edges. More of it makes the skin around joints rounder",
            ),
            Int(
                "max_iterations",
                5,
                minimum=1,
                soft_maximum=50,
                unit="iterations",
                label="Iterations",
                description="The largest number of steps per frame. "
                "A few are enough for joints; long free parts take more",
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
