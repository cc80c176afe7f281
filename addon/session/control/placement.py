# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a control is, as a number to compare."""

from mathutils import Matrix


def fingerprint(matrix: Matrix) -> int:
    """A number that changes with the matrix, to 64 bits."""
    return hash(matrix.copy().freeze())
