# SPDX-License-Identifier: GPL-3.0-or-later
"""Nonlinear surface methods: they minimise an energy, step by step, from a start."""

from typing import Any

from .schema import (
    Bool,
    Choice,
    Family,
    Float,
    Int,
    MeshObject,
    MeshShape,
    Method,
    Reproduced,
    Size,
    Span,
    factorising,
    items,
    iterations,
    solver,
    tolerance,
)

STEPS: dict[str, Any] = {"iterative": True, "reproduces": Reproduced.RIGID_MOTIONS}


_FIELDS = items(
    harmonic="Isolines of a smooth field between the handles",
    geodesic="Isolines by distances along the surface",
    euclidean=("Straight", "Isolines by distances in a straight line"),
)


CELLS = items(
    spokes="Each vertex keeps the edges that meet it rigid",
    rims=(
        "Spokes and Rims",
        "Each vertex also keeps the edges opposite to it rigid: firmer, and more stable on thin triangles",
    ),
)

MEASURES = items(
    share=("Share of the Size", "Thickness is a share of the size of each part of the surface"),
    length="Thickness is a length",
    stiffness=("Stretching and Bending", "Both stiffnesses are set by themselves"),
)


ROWS = (
    Method(
        id="thin_shell_nonlinear",
        number=24,
        label="Rubber Sheet",
        known_as="Nonlinear Thin Shell",
        search="rubber hose tyre kink elastic",
        family=Family.SURFACE_NONLINEAR,
        section="4.3",
        paper="Terzopoulos et al. 1987",
        summary="Bends, stretches and kinks like rubber",
        fails="Presses hollow parts flat where they bend",
        picture="sheets: kink",
        bind_seconds=factorising(0.2),
        **STEPS,
        main=("thickness",),
        parameters=(
            Choice("measure", "Stiffness From", "share", MEASURES).described(
                "Choose what says how stiff the sheet is"
            ),
            Float(
                "thickness",
                "Thickness",
                0.02,
                Span(soft=0.1, digits=4, step=0.1),
                paintable=True,
                only_with=("measure", ("share", "length")),
                share_of=Size.SURFACE,
                share_with=("measure", "share"),
                unit="share of the size, or a length",
            ).described("Set how thick the sheet is: a thin one bends like paper, a thick one stretches"),
            Float(
                "stretching",
                "Stretching",
                1.0,
                Span(0.001, soft=10.0),
                paintable=True,
                only_with=("measure", ("stiffness",)),
                unit="relative weight",
            ).described("Set how much the sheet resists being stretched"),
            Float(
                "bending",
                "Bending",
                1.0,
                Span(soft=10.0, digits=5),
                paintable=True,
                only_with=("measure", ("stiffness",)),
                unit="area, times that of Stretching",
            ).described("Set how much the sheet resists being bent"),
            iterations(60),
            tolerance(),
        ),
    ),
    Method(
        id="arap",
        number=2,
        label="Natural Bend",
        known_as="As-Rigid-As-Possible",
        search="limb arm leg tail elbow pose rigid corrective",
        family=Family.SURFACE_NONLINEAR,
        section="6",
        paper="Sorkine & Alexa 2007, Levi & Gotsman 2015",
        summary="Bends limbs and bodies through large turns, and keeps their details",
        fails="Leaves spikes at handles of a single vertex",
        picture="gallery: branches",
        bind_seconds=factorising(0.12),
        **STEPS,
        main=("rigidity",),
        parameters=(
            Float(
                "smoothness",
                "Evenness",
                5e-4,
                Span(0.0, 10.0, soft=0.01, digits=5),
                unit="share of the rest area",
            ).described(
                "Let neighbouring parts turn evenly, as a share of the area of the surface; "
                "with 0, fine meshes buckle"
            ),
            Choice("cells", "Cells", "spokes", CELLS).described(
                "Make the surface firmer by keeping more edges around each vertex rigid"
            ),
            Float(
                "point_handles",
                "Round Points",
                0.0,
                Span(0.0, 0.99, soft=0.9),
                advanced=True,
                unit="share of the energy",
            ).described(
                "Avoid spikes at handles of a single vertex by 0.5 to 0.9; 0 is right for "
                "handles of many vertices"
            ),
            Float(
                "rigidity", "Rigidity", 1.0, Span(0.001, soft=1.0), paintable=True, unit="relative weight"
            ).described(
                "Set how firmly the surface keeps its shape, everywhere or as a vertex group is painted"
            ),
            iterations(40),
            tolerance(
                1e-3,
                soft=0.01,
                description="Stop when no point has more than this share of the size of the surface "
                "left to go, as the last two steps let expect",
                unit="share of the size",
            ),
            solver(
                "Binds in half the time and less than half the memory, but frames take three times as long"
            ),
        ),
    ),
    Method(
        id="primo",
        number=25,
        label="Thick Sheet",
        known_as="PriMo",
        search="prism thickness stiff leather",
        family=Family.SURFACE_NONLINEAR,
        section="6",
        paper="Botsch, Pauly, Gross & Kobbelt 2006",
        summary="Bends like a sheet as thick as you say",
        fails="Takes long to bind",
        picture="prisms",
        bind_seconds=factorising(0.12),
        **STEPS,
        main=("height",),
        parameters=(
            Float(
                "height",
                "Height",
                0.05,
                Span(0.0001, 10.0, soft=0.2, digits=4),
                paintable=True,
                share_of=Size.SURFACE,
                unit="share of the size",
            ).described("Stiffen bends and twists by a thicker sheet, as a share of the size of the part"),
            iterations(40),
            tolerance(),
        ),
    ),
    Method(
        id="pyramid_coordinates",
        number=26,
        label="Morph",
        known_as="Pyramid Coordinates",
        search="morph blend shape between twins grow",
        family=Family.SURFACE_NONLINEAR,
        section="6",
        paper="Sheffer & Kraevoy 2004, Kraevoy & Sheffer 2006",
        summary="Turns one mesh into its twin; parts turn instead of shrinking",
        fails="Kinks tubes that bend by more than 55 degrees",
        picture="pyramid_coordinates: half",
        also_needs="a twin of the mesh to morph to",
        bind_seconds=factorising(0.2),
        **STEPS,
        main=("morph",),
        parameters=(
            Float(
                "morph", "Morph", 0.0, Span(0.0, 1.0, soft=1.0), rebinds=False, unit="share of the way"
            ).described("Key how far the surface morphs to the target shape"),
            MeshShape("target_shape", "Target Shape").described(
                "Choose the mesh with the same faces to morph to, without its modifiers and shape keys"
            ),
            Float(
                "side",
                "Edge Stiffness",
                0.05,
                Span(0.0001, soft=1.0, digits=4),
                unit="weight of a ring's edges; that of heights is 1 at 1,000 vertices",
            ).described("Set how firmly edges keep their lengths; lower it to let the surface stretch"),
            Bool("similarity", "Let Regions Grow", False).described(
                "Choose whether regions may grow or shrink, up to twice or half their size, "
                "where handles pull them apart or are scaled"
            ),
            iterations(40),
            tolerance(),
        ),
    ),
    Method(
        id="subspace_laplacian",
        number=34,
        label="Plump Bend",
        known_as="Subspace Laplacian",
        search="volume bulge muscle belly fat",
        family=Family.SURFACE_NONLINEAR,
        section="6",
        paper="Huang et al. 2006",
        summary="Bends a body and keeps its volume exactly",
        fails="Smears small bumps, and bends thin sheets badly",
        picture="reduced",
        bind_seconds=lambda points, _size, _options: 0.14 + 5e-5 * points,
        symmetric=False,
        **STEPS,
        main=("keep_volume", "bending"),
        parameters=(
            Bool("keep_volume", "Keep Volume", True).described(
                "Keep the volume of parts that are closed, or nearly, exactly"
            ),
            MeshObject("cage", "Cage").described(
                "Choose a closed mesh around the parts that have handles; without one, each "
                "part gets its own, which is not shown"
            ),
            Int(
                "cage_faces", "Cage Faces", 0, Span(0, 2000, soft=600), earlier=(160, 2), unit="triangles"
            ).described(
                "Bend more freely with more faces of the cage that each part gets; 0 is 160, "
                "and more beside small handles"
            ),
            Float(
                "bending",
                "Bending",
                0.0015,
                Span(0.0, 10.0, soft=0.05, digits=4),
                unit="share of the rest area",
            ).described("Set how stiff the surface is in bends, as a share of its area"),
            Int(
                "clusters", "Clusters", 60, Span(1, 2000, soft=200), advanced=True, unit="clusters per part"
            ).described("Bend finer with more groups of vertices that turn each as one"),
            iterations(60, soft=200),
            tolerance(1e-5, digits=7),
        ),
    ),
    Method(
        id="mesh_puppetry",
        number=29,
        label="Bone Skin",
        known_as="Mesh Puppetry",
        search="skin weights bind rig automatic",
        family=Family.SURFACE_NONLINEAR,
        section="6",
        paper="Shi et al. 2007",
        summary="Keeps limbs rigid between joints and bends the skin there",
        fails="Holds everything where vertex groups overlap all over",
        picture="puppet: hand",
        also_needs="an armature",
        bind_seconds=factorising(0.2),
        **STEPS,
        main=("bending",),
        parameters=(
            Float(
                "bending", "Bending", 1e-3, Span(0.0, 10.0, soft=0.1, digits=5), unit="share of the rest area"
            ).described(
                "Set how much bends and bumps of the surface are kept, beside the lengths of "
                "its edges; more of it makes the skin around joints rounder"
            ),
            iterations(
                20, soft=50, description="Limit the steps of a frame; joints need few, long free parts more"
            ),
            tolerance(),
        ),
    ),
    Method(
        id="handle_aware_isolines",
        number=33,
        label="Banded Bend",
        known_as="Handle-Aware Isolines",
        search="heavy fast million bands isolines",
        family=Family.SURFACE_NONLINEAR,
        section="6",
        paper="Au et al. 2007",
        summary="Bends the heaviest meshes in milliseconds, with few handles",
        fails="Slows down with many handles",
        picture="reduced",
        draws="BANDS",
        bind_seconds=factorising(0.06),
        **STEPS,
        main=("bands",),
        parameters=(
            Int("bands", "Bands", 24, Span(2, 1000, soft=64), unit="bands between two handles").described(
                "Set how many bands between two handles turn each as one; more of them bend "
                "more evenly, and take more memory and time"
            ),
            Choice("field", "Isolines", "harmonic", _FIELDS).described("Choose what bounds the bands"),
            iterations(
                200,
                soft=500,
                unit="turns",
                label="Turns",
                description="Limit how many times the rotations are fitted per frame",
            ),
            tolerance(
                1e-6,
                digits=7,
                unit="norm of a rotation matrix",
                description="Stop when the matrix of no rotation changes by more than this",
            ),
        ),
    ),
)
