# SPDX-License-Identifier: GPL-3.0-or-later
"""Methods around another method, which moves a smooth base of the surface."""

from .schema import Choice, Family, Float, Int, Method, factorising

DETAILS = (
    (
        "displacement_vectors",
        "Displacement Vectors",
        "An arrow per vertex, which turns with the base: quick and safe",
    ),
    (
        "normal_displacements",
        "Normal Displacements",
        "A height above the base per vertex: details spread on outer curves, and fold over in tight bends",
    ),
    (
        "displacement_volumes",
        "Displacement Volumes",
        "The volume between base and surface is kept: the least distortion, also in tight bends, but slow",
    ),
    (
        "deformation_transfer",
        "Deformation Transfer",
        "Each face is deformed as its face of the base is: details grow and shrink with the base",
    ),
)


ROWS = (
    Method(
        id="multiresolution",
        number=20,
        label="Keep Details",
        known_as="Multiresolution",
        search="details bumps sculpt displacement",
        family=Family.MULTIRESOLUTION,
        native="Multiresolution",
        section="4.4",
        paper="Kobbelt et al. 1998, Botsch, Pauly, Kobbelt et al. 2008",
        summary="Turns bumps with the surface instead of shearing them",
        fails="Bends no better than the method that it is put around",
        picture="multiresolution",
        main=("wavelength",),
        bind_seconds=factorising(0.06),
        wraps=(Family.SURFACE_LINEAR, Family.SURFACE_NONLINEAR),
        parameters=(
            Choice(
                "details",
                "displacement_vectors",
                DETAILS,
                rebinds=True,
                label="Details",
                description="Set how the details are stored and put back on the base",
            ),
            Float(
                "wavelength",
                10.0,
                minimum=0.1,
                maximum=1e4,
                soft_maximum=50.0,
                precision=1,
                step=1.0,
                rebinds=True,
                unit="mean edge lengths",
                label="Detail Size",
                description="Set up to which size bumps count as details, in mean lengths of edges",
            ),
            Int(
                "bands",
                1,
                minimum=1,
                maximum=8,
                soft_maximum=4,
                rebinds=True,
                advanced=True,
                unit="bands",
                label="Bands",
                description="Turn fine details with coarser ones, by so many bands that each hold details "
                "of twice the size",
            ),
        ),
    ),
)
