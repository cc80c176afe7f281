# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels, lists, menus and overlays, which draw and never solve."""

from . import bake, data_tab, drag_tool, keymap, lists, menus, panel, pie, prepare, presets, refining, try_it
from .browser import menus as task_menus, pictures, popups
from .overlays import marks, overlay, reach

_MODULES = (
    task_menus,
    popups,
    pictures,
    lists,
    menus,
    pie,
    presets,
    try_it,
    panel,
    overlay,
    reach,
    marks,
    refining,
    bake,
    prepare,
    data_tab,
    keymap,
    drag_tool,
)


def register() -> None:
    for module in _MODULES:
        module.register()


def unregister() -> None:
    for module in reversed(_MODULES):
        module.unregister()
