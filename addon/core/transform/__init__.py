# SPDX-License-Identifier: GPL-3.0-or-later
"""Moves, rotations and scalings by mouse and by typed numbers, as in Blender's own modal tools."""
