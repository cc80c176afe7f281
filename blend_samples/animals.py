# SPDX-License-Identifier: GPL-3.0-or-later
"""Animals that several samples use, with their skin."""

from __future__ import annotations

import bpy

from . import materials
from .models import creature, spot


def dragon() -> bpy.types.Object:
    obj = creature.build()
    obj.data.materials.append(materials.skin_material("Skin", roughness=0.42, bump=0.25, grain=90.0))
    obj.data.materials.append(
        materials.eye_material("Eye", creature.IRIS, creature.PUPIL, creature.IRIS_EDGE)
    )
    return obj


def cow() -> bpy.types.Object:
    pink, brown = (0.72, 0.34, 0.27), (0.085, 0.035, 0.018)
    patches = (
        ("blot", brown, 0.012),
        ("muzzle", pink, 0.020),
        ("nostril", (0.16, 0.05, 0.045), 0.006),
        ("ear", pink, 0.020),
        ("hoof", (0.05, 0.032, 0.025), 0.006),
        ("horn", (0.55, 0.42, 0.26), 0.010),
    )
    obj = spot.build()
    obj.data.materials.append(materials.patched_material("Hide", (0.80, 0.74, 0.66), patches, roughness=0.5))
    obj.data.materials.append(
        materials.plain_material("Bead", (0.005, 0.004, 0.004), roughness=0.06, specular=0.6)
    )
    return obj
