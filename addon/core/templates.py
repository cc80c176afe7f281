# SPDX-License-Identifier: GPL-3.0-or-later
"""Templates: ready values of the parameters of methods, by what the result looks like."""

from dataclasses import dataclass

from .methods import Method


@dataclass(frozen=True)
class Template:
    """A look. ``purpose`` is what it is for, the tooltip of its button."""

    id: str
    label: str
    purpose: str


TEMPLATES = (
    Template("firm", "Firm", "Keep limbs and props stiff, so that the bend spreads far"),
    Template("soft", "Soft", "Bend bodies as gently as skin and clay do"),
    Template("cloth", "Cloth", "Fold flags and skirts easily without a stretch"),
    Template("rubber", "Rubber", "Let hoses and balloons stretch between their handles"),
    Template("cartoon", "Cartoon", "Exaggerate: round bends, and parts that may grow"),
)
TEMPLATE_BY_ID = {template.id: template for template in TEMPLATES}

# For each method its parameters, and their values in each template that fits it. The others need no template:
# they have no setting of that kind, or each of their controls has its own.
_ARAP = (
    ("smoothness", "cells"),
    {"firm": (0.005, "rims"), "soft": (0.0005, "spokes"), "rubber": (0.0001, "spokes")},
)
_VALUES: dict[str, tuple[tuple[str, ...], dict[str, tuple]]] = {
    "arap": _ARAP,
    "mesh_sequence": _ARAP,
    "subspace_laplacian": (
        ("keep_volume", "bending"),
        {"firm": (True, 0.01), "soft": (True, 0.0015), "rubber": (False, 0.001), "cartoon": (True, 0.0003)},
    ),
    "laplacian_editing": (
        ("transforms", "second_stage"),
        {"firm": ("implicit", "length"), "soft": ("estimated", "polar"), "rubber": ("none", "polar")},
    ),
    "handle_aware_isolines": (("bands",), {"firm": (8,), "soft": (24,), "rubber": (48,)}),
    "volumetric_graph_laplacian": (("volume",), {"firm": (4.0,), "soft": (1.0,), "cloth": (0.0,)}),
    "thin_shell": (
        ("stretching", "bending", "variation"),
        {
            "soft": (0.0, 1.0, 0.0),
            "cloth": (1.0, 0.05, 0.0),
            "rubber": (1.0, 0.0, 0.0),
            "cartoon": (0.0, 0.1, 1.0),
        },
    ),
    "primo": (("height",), {"firm": (0.2,), "soft": (0.05,), "cloth": (0.005,)}),
    "thin_shell_nonlinear": (
        ("measure", "thickness"),
        {
            "firm": ("share", 0.03),
            "soft": ("share", 0.01),
            "cloth": ("share", 0.002),
            "rubber": ("share", 0.1),
        },
    ),
    "spline_surface": (
        ("columns", "rows", "smoothing"),
        {"firm": (4, 4, 0.01), "soft": (8, 8, 0.001), "cloth": (16, 16, 0.001)},
    ),
    "mls": (
        ("maps", "alpha"),
        {"firm": ("rigid", 3.0), "soft": ("rigid", 1.6), "cartoon": ("similarity", 2.0)},
    ),
    "rbf": (("kernel",), {"firm": ("biharmonic",), "soft": ("triharmonic",)}),
    "embedded_deformation": (
        ("rotation", "regularity"),
        {"firm": (10.0, 100.0), "soft": (1.0, 10.0), "rubber": (0.1, 1.0)},
    ),
    "rigid_cells": (("cells",), {"firm": (500,), "soft": (4000,)}),
    "wires": (("exponent", "smoothing"), {"firm": (1.0, 0.1), "soft": (0.0, 0.5)}),
    "mesh_puppetry": (
        ("bending",),
        {"firm": (0.0003,), "soft": (0.003,), "rubber": (0.03,), "cartoon": (0.1,)},
    ),
    "pyramid_coordinates": (
        ("side", "similarity"),
        {"firm": (0.5, False), "soft": (0.05, False), "rubber": (0.005, False), "cartoon": (0.05, True)},
    ),
}


def values_of(template: Template, method: Method) -> dict[str, object]:
    """The parameters of the method that the template sets, with their values; none where it does not fit."""
    names, rows = _VALUES.get(method.id, ((), {}))
    return dict(zip(names, rows.get(template.id, ()), strict=True)) if template.id in rows else {}
