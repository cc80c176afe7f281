# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison of surface methods: cases, measures and rows, with NumPy and without Blender."""

from .cases import CASES as CASES
from .cases import Case as Case
from .figures import all_figures as all_figures
from .matrix import Matrix as Matrix
from .matrix import distortion as distortion
from .matrix import filled as filled
from .rows import igl_arap as igl_arap
from .rows import native_solve as native_solve
from .rows import registry_rows as registry_rows
from .space_rows import space_rows as space_rows
