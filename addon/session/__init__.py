# SPDX-License-Identifier: GPL-3.0-or-later
"""Decides when to factorise and when to solve. Operators, handlers and scripts come in by these functions."""

from .blocks.baked import find_cache
from .blocks.capture import points_shown
from .blocks.lattice_keys import show_late
from .blocks.owners import copies, forget_owners, has_copies, owners
from .blocks.parts import ShownParts, shown_parts
from .blocks.references import curve_node, edit_curve, reset_curve
from .blocks.shapes import attribute_names, find_modifier, shown_by, stray_modifiers
from .blocks.surface import Hit, first_hit, nearest_point
from .blocks.targets import can_be_moved, is_exported, is_lattice, is_mesh, label, require_mesh
from .control.handles.points import takes_segments
from .control.handles.riding import carrier_of, standing
from .control.handles.sides import control_pairs
from .control.kinds import lost_controls, marks_regions, object_with, posed_by
from .control.twice import explain as moved_twice
from .edit.apply import apply
from .edit.around import Target
from .edit.automatic import change_cage, check_cage, face_count, is_automatic, moved_by
from .edit.bind import bind, unbind
from .edit.cages import (
    CAGE_METHODS,
    add_cage_object,
    cage_maker,
    cage_seconds,
    flip_cage,
    takes_flat_cage,
)
from .edit.deformers import add_deformer, keep_earlier_defaults, remove_deformer
from .edit.drag import Brush, Drag
from .edit.grids import has_grid, new_grid
from .edit.handles.bones import is_moved_by_control
from .edit.handles.handles import add_handle, new_control, remove_handle
from .edit.handles.mirror import Mirrored, MirrorOptions, handles_of_side, mirror
from .edit.handles.overlaps import part_regions
from .edit.handles.points import empties_on, empty_at, with_points
from .edit.handles.standing import NOTHING_MOVES, stand_on, why_not_on_surface
from .edit.keys import add_key, key_beside, key_notes, move_key, remove_key
from .edit.lattices import LATTICE_METHODS, LatticeShape, add_lattice_object
from .edit.making import BEING_MADE, begin_cage, cage_work, drop_cage
from .edit.order import move_deformer, move_handle
from .edit.puppet.bones import require_bones
from .edit.puppet.posing import Part, PuppetDrag, PuppetOptions
from .edit.puppet.rigging import rig_puppet
from .edit.refining import refine, turn_off_armatures
from .edit.refresh import bind_renders, look_at_renders, refresh
from .edit.repair import Cures, repair
from .edit.repair import summary as repair_summary
from .edit.rigging import (
    rig_control,
    rig_controls,
    rig_points,
    rig_region,
    takes_points,
    try_bind,
    use_control,
    waiting_for_control,
)
from .edit.rows import (
    add_to,
    forget_stops,
    new_tool,
    remove_row,
    rows_of,
    stop_count,
    stop_here,
    tool_reach,
)
from .edit.saving import store, store_shown
from .edit.selection import group_from_selection, group_of, parts_inside, select_elements, select_group
from .edit.sharing import let_outside_follow, refuses_outside, set_rest, share_settings, sharing
from .edit.upkeep import collect, has_pending, restore_shapes, separate_copies, tidy
from .edit.wires import fitting_radius, wire_from_edges, wire_radius, wire_through
from .live.binding import CANCELLED, busy, cancel, duration, job, may_wait, summary, unwatched, watch
from .live.dependencies import circle
from .live.evaluate import settle, update
from .live.mesh_notes import notes
from .live.mirroring import complete_undo, key_partners, mirrored_targets, move_partners
from .live.schedule import begin as begin_evaluation
from .live.schedule import is_waiting
from .memory.background import Work
from .memory.render_writes import carry_out_writes, must_hand_over
from .memory.sessions import (
    find,
    forget_shapes,
    has_counts,
    is_draft,
    is_refining,
    is_suspended,
    note_edit,
    suspended,
    unsettled,
)
from .tools.grab import NOTHING_FREE, Grab
from .tools.sketch import TOO_SHORT, Sight, Sketch, keep_stroke, stroke_of

__all__ = (
    "BEING_MADE",
    "CAGE_METHODS",
    "CANCELLED",
    "LATTICE_METHODS",
    "NOTHING_FREE",
    "NOTHING_MOVES",
    "TOO_SHORT",
    "Brush",
    "Cures",
    "Drag",
    "Grab",
    "Hit",
    "LatticeShape",
    "MirrorOptions",
    "Mirrored",
    "Part",
    "PuppetDrag",
    "PuppetOptions",
    "ShownParts",
    "Sight",
    "Sketch",
    "Target",
    "Work",
    "add_cage_object",
    "add_deformer",
    "add_handle",
    "add_key",
    "add_lattice_object",
    "add_to",
    "apply",
    "attribute_names",
    "begin_cage",
    "begin_evaluation",
    "bind",
    "bind_renders",
    "busy",
    "cage_maker",
    "cage_seconds",
    "cage_work",
    "can_be_moved",
    "cancel",
    "carrier_of",
    "carry_out_writes",
    "change_cage",
    "check_cage",
    "circle",
    "collect",
    "complete_undo",
    "control_pairs",
    "copies",
    "curve_node",
    "drop_cage",
    "duration",
    "edit_curve",
    "empties_on",
    "empty_at",
    "face_count",
    "find",
    "find_cache",
    "find_modifier",
    "first_hit",
    "fitting_radius",
    "flip_cage",
    "forget_owners",
    "forget_shapes",
    "forget_stops",
    "group_from_selection",
    "group_of",
    "handles_of_side",
    "has_copies",
    "has_counts",
    "has_grid",
    "has_pending",
    "is_automatic",
    "is_draft",
    "is_exported",
    "is_lattice",
    "is_mesh",
    "is_moved_by_control",
    "is_refining",
    "is_suspended",
    "is_waiting",
    "job",
    "keep_earlier_defaults",
    "keep_stroke",
    "key_beside",
    "key_notes",
    "key_partners",
    "label",
    "let_outside_follow",
    "look_at_renders",
    "lost_controls",
    "marks_regions",
    "may_wait",
    "mirror",
    "mirrored_targets",
    "move_deformer",
    "move_handle",
    "move_key",
    "move_partners",
    "moved_by",
    "moved_twice",
    "must_hand_over",
    "nearest_point",
    "new_control",
    "new_grid",
    "new_tool",
    "note_edit",
    "notes",
    "object_with",
    "owners",
    "part_regions",
    "parts_inside",
    "points_shown",
    "posed_by",
    "refine",
    "refresh",
    "refuses_outside",
    "remove_deformer",
    "remove_handle",
    "remove_key",
    "remove_row",
    "repair",
    "repair_summary",
    "require_bones",
    "require_mesh",
    "reset_curve",
    "restore_shapes",
    "rig_control",
    "rig_controls",
    "rig_points",
    "rig_puppet",
    "rig_region",
    "rows_of",
    "select_elements",
    "select_group",
    "separate_copies",
    "set_rest",
    "settle",
    "share_settings",
    "sharing",
    "show_late",
    "shown_by",
    "shown_parts",
    "stand_on",
    "standing",
    "stop_count",
    "stop_here",
    "store",
    "store_shown",
    "stray_modifiers",
    "stroke_of",
    "summary",
    "suspended",
    "takes_flat_cage",
    "takes_points",
    "takes_segments",
    "tidy",
    "tool_reach",
    "try_bind",
    "turn_off_armatures",
    "unbind",
    "unsettled",
    "unwatched",
    "update",
    "use_control",
    "waiting_for_control",
    "watch",
    "why_not_on_surface",
    "wire_from_edges",
    "wire_radius",
    "wire_through",
    "with_points",
)
