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
                "point_handles",
                0.0,
                maximum=0.99,
                soft_maximum=0.9,
                rebinds=True,
                unit="share of the energy",
                label="Point Handles",
                description="How smooth the surface is also around handles of a single vertex, which "
                "otherwise leave a spike. 0.5 to 0.9 is right for them, 0 for handles of many vertices. "
                "Only with cells of spokes",
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
        id="primo",
        number=25,
        label="PriMo",
        family=Family.SURFACE_NONLINEAR,
        control=Control.HANDLES,
        native="Primo",
        section="6",
        paper="Botsch, Pauly, Gross & Kobbelt 2006",
        summary="Bends like a sheet that is as thick as you say",
        iterative=True,
        moves=frozenset({Moved.MESH}),
        bind_seconds=factorising(0.25),
        reproduces=Reproduced.RIGID_MOTIONS,
        parameters=(
            Float(
                "height",
                0.05,
                minimum=0.0001,
                maximum=10.0,
                soft_maximum=0.2,
                precision=4,
                paintable=True,
                rebinds=True,
                unit="share of the size",
                label="Height",
                description="How far the prisms on the faces reach above and below the surface, as a share "
                "of the diagonal of its bounding box. Higher prisms resist bending and twisting more. "
                "Paint a vertex group to let regions bend that are less thick",
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
)
