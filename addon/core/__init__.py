# SPDX-License-Identifier: GPL-3.0-or-later
"""What Sinew knows without Blender: the method registry, errors, status texts, motions and small geometry."""
