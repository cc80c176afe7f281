# SPDX-License-Identifier: GPL-3.0-or-later
"""The status of a deformer: what it is doing, what is wrong, and the buttons that help."""

from dataclasses import dataclass, replace
from functools import reduce
from operator import or_

from bpy.types import Context, UILayout

from .. import compat
from ..backend import availability
from ..core import status
from ..core.methods import Control
from ..core.status import Level, Remedy, Status
from ..ids import Operators
from ..preferences import PACKAGE
from ..properties import SinewDeformer
from ..session.actions.controls import making
from ..session.controls import kinds
from ..session.controls import twice as control_twice
from ..session.evaluation import binding, dependencies
from ..session.state import sessions
from ..session.state.background import Work
from .text import columns, draw_text

_ICONS = {Level.NONE: "BLANK1", Level.INFO: "INFO", Level.WARNING: "ERROR", Level.ERROR: "CANCEL"}
_WIDE = 44  # characters; in a wider region, buttons are drawn beside their line instead of below it
_BUTTON = 72  # pixels at scale 1


REFINING = "Refining - the final shape follows"
BAKED = Status(Level.INFO, "Baked: what is greyed out here counts after Unbake", remedy=Remedy.UNBAKE)
DRAFT = "Draft - the full shape follows when playback rests"
NATIVE_MISSING = Status(
    Level.ERROR,
    "The native module does not work here - the preferences say what to install",
    remedy=Remedy.PREFERENCES,
)


@dataclass(frozen=True)
class Button:
    """A button: the operator that it calls, its text and its icon."""

    operator: str
    text: str
    icon: str
    properties: tuple[tuple[str, str | bool], ...] = ()


REMEDIES: dict[Remedy, Button] = {
    Remedy.BIND: Button(Operators.BIND, "Rebind", "FILE_REFRESH"),
    Remedy.CAGE_REST: Button(Operators.CAGE_REST, "New Rest", "MESH_CUBE"),
    Remedy.LATTICE_REST: Button(Operators.LATTICE_REST, "New Rest", "PIVOT_BOUNDBOX"),
    Remedy.FLIP_CAGE: Button(Operators.CAGE_FLIP, "Flip", "NORMALS_FACE"),
    Remedy.OUTSIDE: Button(Operators.CAGE_OUTSIDE, "Follow", "MOD_MESHDEFORM"),
    Remedy.REPAIR: Button(Operators.REPAIR, "Repair", "TOOL_SETTINGS"),
    Remedy.PART_REGIONS: Button(Operators.PART_REGIONS, "Unshare", "NONE"),
    Remedy.REFINE: Button(Operators.REFINE, "Refine", "MESH_GRID"),
    Remedy.ARMATURE_OFF: Button(Operators.ARMATURE_OFF, "Turn Off Armature", "MOD_ARMATURE"),
    Remedy.KEEP_INSIDE: Button(Operators.KEEP_INSIDE, "Keep Inside Parts", "PINNED"),
    Remedy.NEW_CONTROL: Button(Operators.CONTROL_NEW, "New Control", "EMPTY_AXIS"),
    Remedy.BAKE: Button(Operators.BAKE, "Bake Again", "NONE", (("again", True),)),
    Remedy.UNBAKE: Button(Operators.UNBAKE, "Unbake", "LOOP_BACK"),
    Remedy.CONVERT: Button("object.convert", "Convert to Mesh", "OUTLINER_OB_MESH", (("target", "MESH"),)),
    Remedy.OVERRIDE: Button("object.make_override_library", "Make Library Override", "LIBRARY_DATA_OVERRIDE"),
    Remedy.PREFERENCES: Button(
        "preferences.addon_show", "Preferences", "PREFERENCES", (("module", PACKAGE),)
    ),
}


def _buttons(remedy: Remedy) -> list[Button]:
    return [button for each, button in REMEDIES.items() if each in remedy]


def draw_remedy(layout: UILayout, remedy: Remedy) -> None:
    """Draw the buttons of a remedy."""
    for button in _buttons(remedy):
        settings = layout.operator(button.operator, text=button.text, icon=button.icon)
        for name, value in button.properties:
            setattr(settings, name, value)


def draw_message(context: Context, layout: UILayout, line: Status, problem: int = -1) -> None:
    """Draw one line with its buttons. ``problem`` is its number among the lines that name elements, or -1."""
    count = (problem >= 0) + len(_buttons(line.remedy))
    wide = columns(context) >= _WIDE
    group = layout.row() if wide else layout.column(align=True)
    draw_text(context, group.column(), line.text, _ICONS[line.level], beside=_BUTTON * count if wide else 0)
    if not count:
        return
    buttons = group.row(align=True)
    if wide:
        buttons.alignment = "RIGHT"
    if problem >= 0:
        select = buttons.operator(Operators.SELECT_PROBLEMS, text="Show", icon="RESTRICT_SELECT_OFF")
        select.line = problem
    draw_remedy(buttons, line.remedy)


def draw_error(context: Context, layout: UILayout, deformer: SinewDeformer) -> None:
    """Draw why the deformer does not work, or why its settings are greyed out, at the top of the panel, where
    it is seen without scrolling.
    """
    line = headline(deformer)
    if line.level is not Level.ERROR and deformer.bake.is_baked:
        line = BAKED
    elif line.level is not Level.ERROR or binding.job(deformer.uid) is not None:
        return
    draw_message(context, layout.box().column(), line, 0 if line.elements else -1)


def draw_status(context: Context, layout: UILayout, deformer: SinewDeformer) -> None:
    """Draw the status at the end of the panel, and Bind below it."""
    job = binding.job(deformer.uid)
    if job is not None:
        draw_progress(layout.box().column(), job, "Binding")
        return
    cage = making.cage_work(deformer.id_data.name)
    if cage is not None and deformer.definition.control is not Control.CAGE:  # else its own button tells
        draw_progress(layout.box().column(), cage, "making a cage")
    line = headline(deformer)
    problem = int(bool(line.elements))
    lines = [(line, problem - 1)] if line.level is not Level.ERROR else []
    for line in (*status.notes(deformer.uid), *_warnings(deformer)):
        lines.append((line, problem if line.elements else -1))
        problem += bool(line.elements)
    unlocked = deformer.is_bound and not context.scene.render.use_lock_interface
    if lines or unlocked:
        box = layout.box().column()
        for place, (line, number) in enumerate(lines):
            # One press of a button mends what all lines with it say, so the last of them has it.
            later = reduce(or_, (other.remedy for other, _ in lines[place + 1 :]), Remedy.NONE)
            draw_message(context, box, replace(line, remedy=line.remedy & ~later), number)
        if unlocked:
            draw_text(context, box, "Rendering from this window needs a locked interface", "ERROR")
            box.prop(context.scene.render, "use_lock_interface")
    row = layout.row(align=True)
    row.operator(Operators.BIND, text="Rebind" if deformer.is_bound else "Bind", icon="FILE_REFRESH")
    row.operator(Operators.UNBIND, text="Unbind", icon="X")
    if unlocked or any(line.level in (Level.WARNING, Level.ERROR) for line, _number in lines):
        row.operator(Operators.HELP, text="", icon="QUESTION").page = "troubles"


def headline(deformer: SinewDeformer) -> Status:
    """The main line: the status of the session and, if nothing is wrong, the time of the last solve."""
    if availability().module is None:
        return NATIVE_MISSING
    main = status.current(deformer.uid)
    if not main.text:
        return Status(Level.INFO, "Follows" if deformer.is_bound else "At rest - press Bind")
    known = sessions.find(deformer.uid)
    if deformer.bake.is_baked:
        return main
    if main.level is Level.INFO and sessions.is_draft(deformer.uid):
        return Status(Level.INFO, DRAFT)
    if main.level is Level.INFO and sessions.is_refining(deformer.uid):
        return Status(Level.INFO, REFINING)
    if main.level is Level.INFO and deformer.is_bound and known is not None and known.solve_milliseconds:
        text = f"Follows, {binding.duration(known.solve_milliseconds)}"
        return Status(main.level, text, main.elements, main.remedy)
    return main


def _warnings(deformer: SinewDeformer) -> tuple[Status, ...]:
    """What is seen without an evaluation: lost controls, rigs that follow each other, and armatures that move
    the mesh twice.
    """
    lines = (*kinds.lost_controls(deformer), *dependencies.circle(deformer.id_data))
    remedies = [Remedy.NEW_CONTROL if "New Control" in text else Remedy.NONE for text in lines]
    twice = control_twice.explain(deformer.id_data, deformer)
    return (
        *(Status(Level.WARNING, text, remedy=remedy) for text, remedy in zip(lines, remedies)),
        *(Status(Level.WARNING, text, remedy=Remedy.ARMATURE_OFF) for text in twice),
    )


def draw_progress(layout: UILayout, work: Work, doing: str) -> None:
    """Draw how far a thread is, and the button that cancels it. ``doing`` is said before its first stage."""
    row = layout.row(align=True)
    compat.draw_progress(row, work.fraction, work.stage or doing)
    row.operator(Operators.CANCEL, text="", icon="X")
    hint = layout.row()
    hint.active = False
    hint.label(text="Esc cancels", icon="BLANK1")
