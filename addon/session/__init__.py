# SPDX-License-Identifier: GPL-3.0-or-later
"""Decides when to factorise and when to solve. Operators, handlers and scripts come in by these functions."""

from .apply import apply
from .baked import find_cache
from .binding import CANCELLED, busy, cancel, duration, job, may_wait, summary, unwatched, watch
from .cages import add_cage_object, cage_maker, flip_cage, set_cage, set_rest_cage
from .census import forget_owners, owners, posed_by
from .edit import (
    add_deformer,
    add_handle,
    bind,
    group_from_selection,
    remove_deformer,
    remove_handle,
    select_elements,
    select_group,
    unbind,
)
from .evaluate import settle, update
from .grab import NOTHING_FREE, Grab
from .kinds import can_be_moved, is_exported, is_mesh, label, require_mesh, size
from .mirror import Mirrored, MirrorOptions, handles_of_side, mirror, side_of_handle
from .move import move_deformer, move_handle
from .parting import part_regions
from .picking import is_moved_by_control
from .refresh import refresh
from .relay import is_needed, serve
from .repair import Cures, notes, repair
from .repair import summary as repair_summary
from .rig import attribute_names, find_modifier
from .state import distrust, drop_all, edited, find, suspended, unsettled
from .upkeep import collect, copies, has_pending, tidy
from .work import Work

__all__ = (
    "CANCELLED",
    "NOTHING_FREE",
    "Cures",
    "Grab",
    "MirrorOptions",
    "Mirrored",
    "Work",
    "add_cage_object",
    "add_deformer",
    "add_handle",
    "apply",
    "attribute_names",
    "bind",
    "busy",
    "cage_maker",
    "can_be_moved",
    "cancel",
    "collect",
    "copies",
    "distrust",
    "drop_all",
    "duration",
    "edited",
    "find",
    "find_cache",
    "find_modifier",
    "flip_cage",
    "forget_owners",
    "group_from_selection",
    "handles_of_side",
    "has_pending",
    "is_exported",
    "is_mesh",
    "is_moved_by_control",
    "is_needed",
    "job",
    "label",
    "may_wait",
    "mirror",
    "move_deformer",
    "move_handle",
    "notes",
    "owners",
    "part_regions",
    "posed_by",
    "refresh",
    "remove_deformer",
    "remove_handle",
    "repair",
    "repair_summary",
    "require_mesh",
    "select_elements",
    "select_group",
    "serve",
    "set_cage",
    "set_rest_cage",
    "settle",
    "side_of_handle",
    "size",
    "summary",
    "suspended",
    "tidy",
    "unbind",
    "unsettled",
    "unwatched",
    "update",
    "watch",
)
