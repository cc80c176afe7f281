# SPDX-License-Identifier: GPL-3.0-or-later
"""Moving, turning and scaling by mouse and by typed numbers, as in Blender's own modal tools."""
