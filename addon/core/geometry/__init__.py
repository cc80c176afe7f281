# SPDX-License-Identifier: GPL-3.0-or-later
"""Small geometry in NumPy: frames of regions, distances along a surface, and measures of distortion."""
