# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws panels and menus without a window, into a layout that records the calls."""

from types import SimpleNamespace

import bpy

NARROW, WIDE = 229, 450  # pixels: the sidebar as Blender opens it, and as a rigger drags it


class Sheet:
    """A layout that records calls, in order, with all its sub-layouts: ``calls`` are (method, arguments).
    ``greyed`` are the properties, lists and buttons that were drawn while the layout was not enabled, and
    ``buttons`` those of tasks and methods, and whether they can be pressed."""

    def __init__(self, above: "Sheet | None" = None) -> None:
        alone = {"calls": [], "greyed": [], "buttons": [], "enabled": True}
        vars(self).update(vars(above) if above else alone)

    def __getattr__(self, name: str):
        def record(*args, **keywords):
            settings = SimpleNamespace()
            self.calls.append((name, args, keywords, settings))
            assert keywords.get("text", name) or "expand" not in keywords, "buttons without names"
            if not self.enabled:
                self.greyed.extend(arg for arg in args if isinstance(arg, str))
            if name == "operator" and "depress" in keywords:
                self.buttons.append((keywords["text"], self.enabled))
            return settings if name == "operator" else Sheet(self)

        return record

    def operators(self) -> list[tuple[str, SimpleNamespace]]:
        """Operators on buttons, with the properties set."""
        names = ("operator", "operator_menu_enum")
        return [(args[0], settings) for name, args, _keywords, settings in self.calls if name in names]

    def operator_names(self) -> list[str]:
        return [name for name, _settings in self.operators()]

    def menus(self) -> list[str]:
        return [args[0] for name, args, _keywords, _settings in self.calls if name == "menu"]

    def texts(self) -> str:
        return " ".join(keywords["text"] for name, _a, keywords, _s in self.calls if name == "label")

    def properties(self) -> list[str]:
        return [args[1] for name, args, *_rest in self.calls if name in ("prop", "prop_search")]


class DrawContext:
    """The context of a region that is being drawn."""

    def __init__(self, width: int = NARROW, region_type: str = "UI") -> None:
        self.region = SimpleNamespace(width=width, type=region_type)
        self.preferences = DrawPreferences()

    def __getattr__(self, name: str):
        return getattr(bpy.context, name)


class DrawPreferences:
    """Blender's, with a font and a scale that do not depend on the screen."""

    def __init__(self) -> None:
        self.system = SimpleNamespace(ui_scale=1.0)
        self.ui_styles = [SimpleNamespace(widget=SimpleNamespace(points=11.0))]

    def __getattr__(self, name: str):
        return getattr(bpy.context.preferences, name)


def draw(cls: type, context: DrawContext | None = None) -> Sheet:
    sheet = Sheet()
    said = {name: getattr(cls, name) for name in ("role", "ADDING", "DOING") if hasattr(cls, name)}
    cls.draw(SimpleNamespace(layout=sheet, **said), context or DrawContext())
    return sheet


def draw_panel(width: int = NARROW) -> Sheet:
    return draw(bpy.types.SINEW_PT_sinew, DrawContext(width))


def draw_page(addon: str) -> Sheet:
    """What the preferences of the add-on say about the installation."""
    sheet, nothing = Sheet(), lambda *_arguments: None
    values = bpy.context.preferences.addons[addon].preferences
    parts = dict.fromkeys(("_draw_general", "_draw_overlays", "_draw_keymap"), nothing)
    type(values).draw(SimpleNamespace(layout=sheet, section="GENERAL", **parts), bpy.context)
    return sheet
