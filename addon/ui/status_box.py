# SPDX-License-Identifier: GPL-3.0-or-later
"""The status of a deformer: what it is doing, what is wrong, and the buttons that help."""

import itertools
from dataclasses import replace

from bpy.types import Context, UILayout

from .. import compat
from ..backend import availability
from ..core import status
from ..core.labels import label_of
from ..core.methods import BY_ID, DEFAULT_CAGE_METHOD, Control
from ..core.status import Level, Remedy, Status
from ..ids import Operators
from ..preferences import PACKAGE
from ..properties import SinewDeformer
from ..session.actions.controls import making
from ..session.controls import kinds, twice as control_twice
from ..session.evaluation import binding, dependencies
from ..session.state import sessions
from ..session.state.background import Work
from .layouts import Button, beside
from .pose import draw_drag
from .text import draw_text, is_wide, width_of, width_of_button

_ICONS = {Level.NONE: "BLANK1", Level.INFO: "INFO", Level.WARNING: "ERROR", Level.ERROR: "CANCEL"}
_GAP = 12  # pixels at scale 1, at the sides of a button beside its line

REFINING = "Refining - the final shape follows"
DRAFT = "Draft - the full shape follows when playback rests"
NATIVE_MISSING = Status(
    Level.ERROR,
    "The native module does not work here - the preferences say what to install",
    remedy=Remedy.PREFERENCES,
)
UPDATED = Status(
    Level.WARNING,
    "Sinew was updated - save and restart Blender. Until then shapes stay as they are",
    remedy=Remedy.PREFERENCES,
)


_QUICK_CAGE = BY_ID[DEFAULT_CAGE_METHOD]
_BUTTONS: dict[Remedy, Button] = {
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
    Remedy.STOP_REFINING: Button(Operators.FAST_SUBDIVISION, "Stop Fast Subdivision", "X", (("stop", True),)),
    Remedy.USE_FACTOR: Button(Operators.USE_FACTOR, "Use Factor", "MEMORY"),
    Remedy.NEW_CONTROL: Button(Operators.CONTROL_NEW, "New Control", "EMPTY_AXIS"),
    Remedy.BAKE: Button(Operators.BAKE, "Bake Again", "NONE", (("again", True),)),
    Remedy.FIND_FILE: Button(Operators.BAKE_FIND, "Find File...", "FILEBROWSER"),
    Remedy.UNBAKE: Button(Operators.UNBAKE, "Unbake", "LOOP_BACK"),
    Remedy.CONVERT: Button("object.convert", "Convert to Mesh", "OUTLINER_OB_MESH", (("target", "MESH"),)),
    Remedy.OVERRIDE: Button("object.make_override_library", "Override to Pose It", "LIBRARY_DATA_OVERRIDE"),
    Remedy.PREFERENCES: Button(
        "preferences.addon_show", "Preferences", "PREFERENCES", (("module", PACKAGE),)
    ),
}


def remedies() -> dict[Remedy, Button]:
    """The button of each remedy; one names a method, as the preference *Names* says."""
    quick = Button(
        Operators.METHOD_USE, f"Use {label_of(_QUICK_CAGE)}", "MESH_CUBE", (("method", _QUICK_CAGE.id),)
    )
    return {**_BUTTONS, Remedy.QUICK_CAGE: quick}


def _buttons(remedy: Remedy) -> list[Button]:
    return [button for each, button in remedies().items() if each in remedy]


def draw_remedy(layout: UILayout, remedy: Remedy) -> None:
    """Draw the buttons of a remedy."""
    for button in _buttons(remedy):
        button.draw(layout)


def draw_message(context: Context, layout: UILayout, line: Status, problem: int = -1) -> None:
    """Draw one line with its buttons. ``problem`` is its number among the lines that name elements, or -1."""
    show = Button(Operators.SELECT_PROBLEMS, "Show", "RESTRICT_SELECT_OFF", (("line", problem),))
    buttons = [show] * (problem >= 0) + _buttons(line.remedy)
    looks = [button.looks for button in buttons]
    room = sum(width_of_button(context, *look) + _GAP for look in looks)
    wide = is_wide(context) and room < width_of(context, boxed=True) / 2.0
    group = layout.row() if wide else layout.column(align=True)
    group.alert = line.level is Level.ERROR
    draw_text(context, group.column(), line.text, _ICONS[line.level], beside=room if wide else 0)
    if not buttons:
        return
    place = group.row(align=True) if wide else beside(context, group, *looks, boxed=True)
    if wide:
        place.alignment = "RIGHT"
    for button in buttons:
        button.draw(place)


def _draw_messages(context: Context, box: UILayout, lines: list[tuple[Status, int]]) -> None:
    """Draw several lines. One press of a button mends what all lines with it say, so the last has it."""
    later = Remedy.NONE
    shown = []
    for line, problem in reversed(lines):
        shown.append((replace(line, remedy=line.remedy & ~later), problem))
        later |= line.remedy
    for line, problem in reversed(shown):
        draw_message(context, box, line, problem)


def draw_troubles(context: Context, layout: UILayout, deformer: SinewDeformer) -> None:
    """Draw what is wrong, or that a bake is shown, at the top of the panel, where it is seen at once."""
    lines = [pair for pair in _lines(deformer) if pair[0].level in (Level.WARNING, Level.ERROR)]
    if deformer.bake.is_baked and binding.job(deformer.uid) is None:
        remedy = Remedy.UNBAKE | Remedy.BAKE
        lines.insert(0, (Status(Level.INFO, deformer.bake.summary, remedy=remedy), -1))
    unlocked = deformer.is_bound and not context.scene.render.use_lock_interface
    if not lines and not unlocked:
        return
    box = layout.box().column()
    _draw_messages(context, box, lines)
    if unlocked:
        draw_text(context, box, "Rendering from this window needs a locked interface", "ERROR")
        box.prop(context.scene.render, "use_lock_interface")


def without_native() -> Status | None:
    """Why nothing can be computed, or None if the native module is here."""
    found = availability()
    if found.module is not None:
        return None
    return UPDATED if found.is_outdated else NATIVE_MISSING


def has_troubles(deformer: SinewDeformer) -> bool:
    """Whether something is wrong that the page of troubles tells more about."""
    return any(line.level in (Level.WARNING, Level.ERROR) for line, _problem in _lines(deformer))


def draw_status(context: Context, layout: UILayout, deformer: SinewDeformer) -> None:
    """Draw what the deformer does at the end of the panel; while it is bound, how far that is."""
    job = binding.job(deformer.uid)
    if job is not None:
        draw_progress(layout.column(), job, "Binding")
        return
    cage = making.cage_work(deformer.id_data.name)
    if cage is not None and deformer.definition.control is not Control.CAGE:  # else its own button tells
        draw_progress(layout.column(), cage, "making a cage")
    if not deformer.bake.is_baked:
        _draw_headline(context, layout, deformer)
    notes = [pair for pair in _lines(deformer)[1:] if pair[0].level not in (Level.WARNING, Level.ERROR)]
    if notes:
        _draw_messages(context, layout.box().column(), notes)


def _draw_headline(context: Context, layout: UILayout, deformer: SinewDeformer) -> None:
    """Draw whether it follows, and the button that binds it. What is wrong is at the top of the panel."""
    line = headline(deformer)
    wrong = line.level in (Level.WARNING, Level.ERROR)
    icon = _ICONS[Level.WARNING] if wrong else "CHECKMARK" if deformer.is_bound else _ICONS[Level.INFO]
    bound = deformer.is_bound
    place = layout.row(align=True) if bound else layout.column(align=True)
    stands = "At rest" if availability().module else "Shows the last solution"
    draw_text(context, place.column(), stands if wrong else line.text, icon, beside=20 * bound, boxed=False)
    if kinds.kind_in_use(deformer).is_set(deformer):
        place.operator(Operators.BIND, text="" if bound else "Bind", icon="FILE_REFRESH")
    elif kinds.marks_regions(deformer.definition):
        draw_drag(place, "POINTS" if deformer.definition.is_space else "SURFACE")


def _lines(deformer: SinewDeformer) -> list[tuple[Status, int]]:
    """All lines about a deformer, the main one first, each with its number among those with elements."""
    lines = (headline(deformer), *status.notes(deformer.uid), *_warnings(deformer))
    numbers = itertools.count()
    return [(line, next(numbers) if line.elements else -1) for line in lines]


def headline(deformer: SinewDeformer) -> Status:
    """The main line: the status of the session and, if nothing is wrong, the time of the last solve."""
    missing = without_native()
    if missing is not None:
        return missing
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
        text = f"Follows, {binding.duration(known.solve_milliseconds).removeprefix('less than ')}"
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
