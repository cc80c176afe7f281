# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison of surface methods: cases, measures and rows, with NumPy and without Blender."""

from .cases import CASES as CASES, Case as Case
from .figures import FIGURES as FIGURES
from .matrix import Matrix as Matrix, distortion as distortion, filled as filled
from .rows import igl_arap as igl_arap, native_solve as native_solve, registry_rows as registry_rows
from .space_rows import space_rows as space_rows
