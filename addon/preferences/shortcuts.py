# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys the add-on asks for: ``ui`` registers them, the page in Preferences lists them for editing."""

from dataclasses import dataclass

from bpy.types import KeyConfig, KeyMap, KeyMapItem

from ..ids import Menus, Operators


@dataclass(frozen=True)
class Shortcut:
    """One item of a keymap.

    ``key`` is Blender's event type. Operator and ``properties`` tell items apart, as keys may be changed.
    """

    operator: str
    key: str
    shift: bool = False
    ctrl: bool = False
    alt: bool = False
    properties: tuple[tuple[str, str], ...] = ()


KEYMAP = "3D View"  # every mode has it; Blender's keymaps of the modes come first, and leave these keys alone
SPACE = "VIEW_3D"

SHORTCUTS: tuple[Shortcut, ...] = (
    Shortcut("wm.call_menu_pie", "Y", shift=True, properties=(("name", Menus.PIE),)),
    Shortcut(Operators.GRAB_REGION, "Y", alt=True),
    Shortcut(Operators.BIND, "Y", shift=True, ctrl=True),
)


def find_item(keymap: KeyMap, shortcut: Shortcut) -> KeyMapItem | None:
    """The item of a shortcut, whatever key it has now."""
    for item in keymap.keymap_items:
        if item.idname == shortcut.operator and all(
            getattr(item.properties, name, None) == value for name, value in shortcut.properties
        ):
            return item
    return None


def find_items(keyconfig: KeyConfig | None) -> list[tuple[KeyMap, KeyMapItem]]:
    """Our items in a keyconfig; it is None, or empty, where Blender has no window."""
    keymap = None if keyconfig is None else keyconfig.keymaps.get(KEYMAP)
    if keymap is None:
        return []
    found = (find_item(keymap, shortcut) for shortcut in SHORTCUTS)
    return [(keymap, item) for item in found if item is not None]
