# SPDX-License-Identifier: GPL-3.0-or-later
"""The keyboard shortcuts. ``ui`` registers them, and the page in Preferences lists them for editing."""

from dataclasses import dataclass

from bpy.types import KeyConfig, KeyMap, KeyMapItem

from ..ids import Menus, Operators


@dataclass(frozen=True)
class Shortcut:
    """One item of a keymap.

    ``key`` is Blender's event type. Since users may change keys, an item is identified by its operator and
    its ``properties``.
    """

    operator: str
    key: str
    shift: bool = False
    ctrl: bool = False
    alt: bool = False
    properties: tuple[tuple[str, str], ...] = ()


KEYMAP = "3D View"  # used in all modes; Blender's own keymaps come first, and do not use these keys
SPACE = "VIEW_3D"

SHORTCUTS: tuple[Shortcut, ...] = (
    Shortcut("wm.call_menu_pie", "Y", shift=True, properties=(("name", Menus.PIE),)),
    Shortcut(Operators.GRAB_REGION, "Y", alt=True),  # in Edit Mode
    Shortcut(Operators.SILHOUETTE_SKETCH, "Y", alt=True),  # elsewhere
    Shortcut(Operators.BIND, "Y", shift=True, ctrl=True),
)


def find_item(keymap: KeyMap, shortcut: Shortcut) -> KeyMapItem | None:
    """The keymap item of a shortcut, whatever its key is now."""
    for item in keymap.keymap_items:
        if item.idname == shortcut.operator and all(
            getattr(item.properties, name, None) == value for name, value in shortcut.properties
        ):
            return item
    return None


def find_items(keyconfig: KeyConfig | None) -> list[tuple[KeyMap, KeyMapItem]]:
    """The keymap items of all shortcuts in a keyconfig, which is None or empty without a window."""
    keymap = None if keyconfig is None else keyconfig.keymaps.get(KEYMAP)
    if keymap is None:
        return []
    found = (find_item(keymap, shortcut) for shortcut in SHORTCUTS)
    return [(keymap, item) for item in found if item is not None]
