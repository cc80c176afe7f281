# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws what *Try It* offers, and the steps of the rig that it has opened."""

from bpy.types import AddonPreferences, Context, Menu, UILayout
from bpy.utils import register_classes_factory

from ..core.rigs import RIGS, rig_after
from ..ids import Menus, Operators
from ..preferences import preferences
from ..session.actions import try_it
from .text import draw_text


class SINEW_MT_try_it(Menu):
    """Small rigs to try Sinew on, each in a scene of its own"""

    bl_idname = Menus.TRY_IT
    bl_label = "Try It"

    def draw(self, _context: Context) -> None:
        for rig in RIGS:
            self.layout.operator(Operators.TRY_IT, text=rig.label, icon=rig.icon).rig = rig.id


def draw_offer(context: Context, layout: UILayout) -> None:
    """Draw the box for those who are new, unless they have hidden it."""
    chosen = preferences(context)
    if not chosen.show_try_it or try_it.rig_of(context.scene) is not None:
        return
    box = layout.box()
    row = box.row()
    row.label(text="New here?")
    if isinstance(chosen, AddonPreferences):
        row.prop(chosen, "show_try_it", text="", icon="X", emboss=False)
    box.menu(Menus.TRY_IT, icon="PLAY")


def draw_steps(context: Context, layout: UILayout) -> None:
    """Draw the steps of a rig, those that are done with a tick, and the ways on and back."""
    rig = try_it.rig_of(context.scene)
    if rig is None:
        return
    box = layout.box()
    box.label(text=rig.label, icon=rig.icon)
    done, steps = try_it.steps_done(context.scene), box.column()
    for number, step in enumerate(rig.steps):
        line = steps.column()
        line.active = number <= done
        draw_text(context, line, step.shown, "CHECKBOX_HLT" if number < done else "CHECKBOX_DEHLT")
    column, following = box.column(align=True), rig_after(rig)
    column.scale_y = 1.3 if done == len(rig.steps) else 1.0
    if following is not None:
        column.operator(Operators.TRY_IT, text="Next Rig", icon="FORWARD").rig = following.id
    column.operator(Operators.TRY_BACK, icon="LOOP_BACK")


register, unregister = register_classes_factory((SINEW_MT_try_it,))
