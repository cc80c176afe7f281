# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels, lists and menus: they draw, and never solve."""

from . import lists, menus, panel

_MODULES = (lists, panel, menus)


def register() -> None:
    for module in _MODULES:
        module.register()


def unregister() -> None:
    for module in reversed(_MODULES):
        module.unregister()
