# SPDX-License-Identifier: GPL-3.0-or-later
"""Decides when to factorise and when to solve. Operators, handlers and scripts come in by these functions."""

from .binding import CANCELLED, HEAVY, busy, cancel, duration, job, may_wait
from .census import forget_owners, has_copies, owners, posed_by
from .edit import (
    add_deformer,
    add_handle,
    apply,
    bind,
    group_from_selection,
    remove_deformer,
    remove_handle,
    select_elements,
    select_group,
    unbind,
)
from .evaluate import settle, update
from .rig import find_modifier
from .state import distrust, drop_all, find, is_suspended, rewired, unsettled
from .upkeep import collect, copies, tidy

__all__ = (
    "CANCELLED",
    "HEAVY",
    "add_deformer",
    "add_handle",
    "apply",
    "bind",
    "busy",
    "cancel",
    "collect",
    "copies",
    "distrust",
    "drop_all",
    "duration",
    "find",
    "find_modifier",
    "forget_owners",
    "group_from_selection",
    "has_copies",
    "is_suspended",
    "job",
    "may_wait",
    "owners",
    "posed_by",
    "remove_deformer",
    "remove_handle",
    "rewired",
    "select_elements",
    "select_group",
    "settle",
    "tidy",
    "unbind",
    "unsettled",
    "update",
)
