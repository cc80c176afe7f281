# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: presses *Check This Installation* in the preferences of the add-on."""

import sys
from pathlib import Path

import addon_utils
import bpy
from driving import MODULE, OUTPUT, click, enable, move, play, rest, seen, until, viewport, window

_BUTTON = 610, 330  # from the left upper corner of the preferences to the button, in pixels


def picture(name: str) -> None:
    with bpy.context.temp_override(window=window()):
        bpy.ops.screen.screenshot(filepath=str(OUTPUT / f"{name}.png"))


def journey():
    enable()
    area = viewport()
    area.type = "PREFERENCES"
    bpy.context.preferences.active_section = "ADDONS"
    bpy.context.window_manager.addon_search = "Sinew"
    addon = next(module for module in addon_utils.modules() if module.__name__ == MODULE)
    addon_utils.module_bl_info(addon)["show_expanded"] = True
    yield from rest(8)
    check = sys.modules[f"{MODULE}.backend"].last_check
    left, top = _BUTTON
    yield from click(area.x + left, area.y + area.height - top)
    yield from until(lambda: check().report != "")
    move(area.x + 20, area.y + 20)
    yield from rest(4)
    picture("checked")
    found = check()
    seen["found"] = [found.asked, found.wrong, found.summary]
    report = Path(found.report)
    seen["report"] = report.read_text(encoding="utf-8")
    report.unlink()


play(journey())
