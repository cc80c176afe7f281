# SPDX-License-Identifier: GPL-3.0-or-later
"""The only door to the native module."""

from .loader import Availability
from .native import (
    Diagnosis,
    Factor,
    automatic_cage,
    availability,
    build_factor,
    diagnose,
    limit_memory,
    limit_threads,
)
from .recipes import Base, CageRecipe, CageReport, Progress, Recipe

__all__ = (
    "Availability",
    "Base",
    "CageRecipe",
    "CageReport",
    "Diagnosis",
    "Factor",
    "Progress",
    "Recipe",
    "automatic_cage",
    "availability",
    "build_factor",
    "diagnose",
    "limit_memory",
    "limit_threads",
)
