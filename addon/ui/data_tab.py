# SPDX-License-Identifier: GPL-3.0-or-later
"""The same panels in the Modifiers tab of the Properties editor, where riggers look for deformers."""

from bpy.utils import register_classes_factory

from . import bake, panel, prepare
from .overlays import overlay
from .places import in_properties

_ORIGINALS = (*panel.PANELS, *overlay.PANELS, *bake.PANELS, *prepare.PANELS)

register, unregister = register_classes_factory(tuple(in_properties(original) for original in _ORIGINALS))
