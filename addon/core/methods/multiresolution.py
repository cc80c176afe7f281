# SPDX-License-Identifier: GPL-3.0-or-later
"""Methods around another method, which moves a smooth base of the surface."""

from .schema import Choice, Family, Float, Int, Method, Span, factorising, items

DETAILS = items(
    displacement_vectors="An arrow per vertex, which turns with the base: quick and safe",
    normal_displacements="A height above the base per vertex: details spread on outer curves, "
    "and fold over in tight bends",
    displacement_volumes="The volume between base and surface is kept: the least distortion, "
    "also in tight bends, but slow",
    deformation_transfer="Each face is deformed as its face of the base is: "
    "details grow and shrink with the base",
)


ROWS = (
    Method(
        id="multiresolution",
        number=20,
        label="Keep Details",
        known_as="Multiresolution",
        search="details bumps sculpt displacement",
        family=Family.MULTIRESOLUTION,
        section="4.4",
        paper="Kobbelt et al. 1998, Botsch, Pauly, Kobbelt et al. 2008",
        summary="Turns bumps with the surface instead of shearing them",
        fails="Bends no better than the method that it is put around",
        picture="multiresolution",
        bind_seconds=factorising(0.06),
        wraps=(Family.SURFACE_LINEAR, Family.SURFACE_NONLINEAR),
        main=("wavelength",),
        parameters=(
            Choice("details", "Details", "displacement_vectors", DETAILS).described(
                "Set how the details are stored and put back on the base"
            ),
            Float(
                "wavelength",
                "Detail Size",
                10.0,
                Span(0.1, 1e4, soft=50.0, digits=1, step=1.0),
                unit="mean edge lengths",
            ).described("Set up to which size bumps count as details, in mean lengths of edges"),
            Int("bands", "Bands", 1, Span(1, 8, soft=4), advanced=True, unit="bands").described(
                "Turn fine details with coarser ones, by so many bands that each hold details "
                "of twice the size"
            ),
        ),
    ),
)
