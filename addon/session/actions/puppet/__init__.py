# SPDX-License-Identifier: GPL-3.0-or-later
"""An armature as a puppet: its bones are dragged, and its limbs hold a mesh."""
