# SPDX-License-Identifier: GPL-3.0-or-later
"""The code that needs no Blender: the method registry, errors, status texts, motions and small geometry."""
