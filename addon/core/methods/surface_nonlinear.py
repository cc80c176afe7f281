# SPDX-License-Identifier: GPL-3.0-or-later
"""Nonlinear surface methods: they minimise an energy, step by step, from a start."""

from .schema import (
    Bool,
    Choice,
    Control,
    Family,
    Float,
    Int,
    MeshShape,
    Method,
    Moved,
    Reproduced,
    factorising,
)

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
        id="pyramid_coordinates",
        number=26,
        label="Pyramid Coordinates",
        family=Family.SURFACE_NONLINEAR,
        control=Control.HANDLES,
        native="PyramidCoordinates",
        section="6",
        paper="Sheffer & Kraevoy 2004, Kraevoy & Sheffer 2006",
        summary="Keeps each vertex over its neighbours; lets regions grow, and morphs between two meshes",
        iterative=True,
        moves=frozenset({Moved.MESH}),
        bind_seconds=factorising(0.2),
        reproduces=Reproduced.RIGID_MOTIONS,
        parameters=(
            Float(
                "side",
                0.05,
                minimum=0.0001,
                soft_maximum=1.0,
                precision=4,
                rebinds=True,
                unit="weight of a ring's edges; that of heights is 1 at 1,000 vertices",
                label="Edge Stiffness",
                description="How firmly edges keep their lengths, in comparison with how firmly the surface "
                "keeps its curvature. Lower it to let the surface stretch",
            ),
            Bool(
                "similarity",
                False,
                rebinds=True,
                label="Let Regions Grow",
                description="Whether regions may grow or shrink, up to twice or half their size, where "
                "handles pull them apart or are scaled",
            ),
            MeshShape(
                "target_shape",
                rebinds=True,
                label="Target Shape",
                description="A mesh with the same faces to morph to, without its modifiers and shape keys. "
                "Bind again after editing it",
            ),
            Float(
                "morph",
                0.0,
                maximum=1.0,
                soft_maximum=1.0,
                unit="share of the way",
                label="Morph",
                description="How far the surface morphs to the target shape. Can be keyed; needs no new bind",
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
