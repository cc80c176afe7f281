# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison of surface methods: cases, measures and rows, with NumPy and without Blender."""

from .cases import CASES, Case
from .figures import Figure, all_figures
from .matrix import Cell, Matrix, filled
from .measures import Distortion, distortion
from .rows import Solve, igl_arap, native_solve, registry_rows
from .space_rows import space_rows

__all__ = (
    "CASES",
    "Case",
    "Cell",
    "Distortion",
    "Figure",
    "Matrix",
    "Solve",
    "all_figures",
    "distortion",
    "filled",
    "igl_arap",
    "native_solve",
    "registry_rows",
    "space_rows",
)
