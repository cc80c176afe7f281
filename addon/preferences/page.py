# SPDX-License-Identifier: GPL-3.0-or-later
"""Defaults of new deformers, limits, colours, shortcuts, and whether the native module works."""

import textwrap
from types import SimpleNamespace

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty
from bpy.types import AddonPreferences, Context, UILayout

from .. import compat
from ..backend import availability, last_check, limit_memory, limit_threads
from ..core.field import field
from ..core.labels import Names, choose, items_of
from ..core.methods import BY_ID, DEFAULT_METHOD, METHODS
from ..ids import Operators
from .shortcuts import find_items

PACKAGE = __package__.rpartition(".")[0]
_GIGABYTE = 1024**3

DEFAULTS = SimpleNamespace(
    method=DEFAULT_METHOD,
    names=Names.TASKS.name,
    auto_rebind=False,
    drag_budget=40.0,
    threads=0,
    memory_limit=0.0,
    overlay_fixed=(0.17, 0.24, 0.34),
    overlay_compressed=(0.010, 0.112, 0.604),
    overlay_stretched=(0.604, 0.015, 0.010),
    overlay_opacity=0.75,
    show_try_it=True,
)


def _limits_changed(values: "SinewPreferences", _context: Context) -> None:
    apply_limits(values)


def apply_limits(values: "SinewPreferences | SimpleNamespace") -> None:
    """Tell the native module how much of the machine it may use."""
    limit_threads(values.threads)
    limit_memory(round(values.memory_limit * _GIGABYTE))


def _names_changed(values: "SinewPreferences", _context: Context) -> None:
    apply_names(values)


def _kept(_values: "SinewPreferences", context: Context) -> None:
    """Let Blender save the preferences when it quits, as if the setting had been changed on their page."""
    context.preferences.is_dirty = True


def apply_names(values: "SinewPreferences | SimpleNamespace") -> None:
    """Show methods by the chosen names, at once in all windows."""
    choose(Names[values.names])
    for window in getattr(bpy.context.window_manager, "windows", ()):
        for area in window.screen.areas:
            area.tag_redraw()


def _overlay_colour(name: str, default: tuple[float, float, float], description: str):
    return field(FloatVectorProperty, default=default, subtype="COLOR", size=3, min=0.0, max=1.0).named(
        name, description
    )


class SinewPreferences(AddonPreferences):
    """Defaults of new deformers, limits, colours, shortcuts, and whether the native module works"""

    bl_idname = PACKAGE

    section: field(
        EnumProperty,
        items=(
            ("GENERAL", "General", "Defaults of new deformers, and how much of the machine Sinew may use", 0),
            ("OVERLAYS", "Show", "Colours of regions and of distortion in the viewport", 1),
            ("KEYMAP", "Keymap", "Keyboard shortcuts of the add-on in the 3D Viewport", 2),
        ),
        default="GENERAL",
        options={"SKIP_SAVE"},
    ).named("Section", "Choose which of the settings below are shown")
    method: field(EnumProperty, items=items_of(METHODS), default=BY_ID[DEFAULT_METHOD].number).named(
        "Method", "Choose the method that Make Handle starts with; each deformer can change it"
    )
    names: field(
        EnumProperty,
        items=(
            (Names.TASKS.name, "Tasks", "By what they are for, such as Natural Bend", 0),
            (Names.LITERATURE.name, "Literature", "By what is published about them", 1),
        ),
        default=DEFAULTS.names,
        update=_names_changed,
    ).named("Names", "Choose what methods are called, in all panels, menus and messages")
    show_try_it: field(BoolProperty, default=DEFAULTS.show_try_it, update=_kept).named(
        "Show Try It", "Show a box that offers small rigs to try Sinew on, while nothing is posed yet"
    )
    auto_rebind: field(BoolProperty, default=DEFAULTS.auto_rebind).named(
        "Automatic Rebind",
        "Bind new deformers again by themselves when their mesh, or an object whose points move "
        "it, gains or loses points, as you switch between modelling and posing",
    )
    drag_budget: field(
        FloatProperty,
        default=DEFAULTS.drag_budget,
        min=1.0,
        max=10000.0,
        soft_min=5.0,
        soft_max=200.0,
        step=100,
        precision=0,
    ).named(
        "Drag Budget",
        "Set the milliseconds that an iterative method may spend on each redraw during a drag; "
        "the exact shape follows when you stop; lower values are smoother, higher values are "
        "closer to the exact shape",
    )
    threads: field(
        IntProperty, default=DEFAULTS.threads, min=0, max=1024, soft_max=64, update=_limits_changed
    ).named(
        "Threads",
        "Use at most this many processor threads for binding and solving; 0 uses all of them; "
        "lower it to leave some of them to a render",
    )
    memory_limit: field(
        FloatProperty,
        default=DEFAULTS.memory_limit,
        min=0.0,
        max=100000.0,
        soft_max=256.0,
        step=100,
        precision=1,
        update=_limits_changed,
    ).named(
        "Memory Limit",
        "Refuse to bind a mesh that needs more memory than this, in gigabytes; 0 sets no "
        "limit; set it if a large bind must not slow down the machine",
    )
    overlay_fixed: _overlay_colour(
        "Still",
        DEFAULTS.overlay_fixed,
        "Choose the colour of regions that stay where they are; handles have their own",
    )
    overlay_compressed: _overlay_colour(
        "Compressed",
        DEFAULTS.overlay_compressed,
        "Choose the colour of parts that became smaller than at rest",
    )
    overlay_stretched: _overlay_colour(
        "Stretched", DEFAULTS.overlay_stretched, "Choose the colour of parts that became larger than at rest"
    )
    overlay_opacity: field(
        FloatProperty, default=DEFAULTS.overlay_opacity, min=0.0, max=1.0, subtype="FACTOR"
    ).named("Opacity", "Set how much of the mesh an overlay covers; lower it to keep the shading visible")

    def draw(self, context: Context) -> None:
        layout = self.layout
        _draw_native(layout)
        _draw_check(layout)
        layout.row().prop(self, "section", expand=True)
        {"GENERAL": self._draw_general, "OVERLAYS": self._draw_overlays, "KEYMAP": self._draw_keymap}[
            self.section
        ](context, layout.column())

    def _draw_general(self, _context: Context, layout: UILayout) -> None:
        layout.use_property_split = True
        column = layout.column()
        column.prop(self, "method", text="New Deformers")
        column.prop(self, "names")
        column.prop(self, "auto_rebind")
        column.prop(self, "show_try_it")
        layout.separator()
        column = layout.column()
        column.prop(self, "drag_budget", text="Drag Budget (ms)")
        column.prop(self, "threads", text="Threads (0 for All)")
        column.prop(self, "memory_limit", text="Memory Limit (GB, 0 for None)")

    def _draw_overlays(self, _context: Context, layout: UILayout) -> None:
        layout.use_property_split = True
        for name in ("overlay_fixed", "overlay_compressed", "overlay_stretched"):
            layout.prop(self, name)
        layout.prop(self, "overlay_opacity", slider=True)

    def _draw_keymap(self, context: Context, layout: UILayout) -> None:
        keyconfig = context.window_manager.keyconfigs.user
        found = find_items(keyconfig)
        for keymap, item in found:
            compat.draw_keymap_item(layout, keyconfig, keymap, item)
        if not found:
            layout.label(
                text="No shortcuts: they were removed from the keymap, or Blender has no window", icon="INFO"
            )


def _draw_native(layout: UILayout) -> None:
    found = availability()
    if found.module is None:
        _draw_lines(layout, found.remedy, "ERROR")
    else:
        layout.label(text=f"Native module {found.module.__version__} is ready", icon="CHECKMARK")


def _draw_check(layout: UILayout) -> None:
    """The button, and what the last check of this process found."""
    row = layout.row()
    row.operator(Operators.CHECK_INSTALLATION, icon="VIEWZOOM")
    last = last_check()
    if not last.report:
        return
    row.operator("wm.path_open", text="Open the Report", icon="TEXT").filepath = last.report
    layout.label(text=last.summary, icon="CHECKMARK" if last.is_right else "ERROR")
    _draw_lines(layout, last.report, "BLANK1")


def _draw_lines(layout: UILayout, text: str, icon: str) -> None:
    for number, line in enumerate(textwrap.wrap(text, 90)):
        layout.label(text=line, icon="BLANK1" if number else icon)


def preferences(context: Context) -> "SinewPreferences | SimpleNamespace":
    """The preferences of the add-on; the defaults if they have no entry in Blender's Preferences."""
    entry = context.preferences.addons.get(PACKAGE)
    return entry.preferences if entry is not None and entry.preferences is not None else DEFAULTS
