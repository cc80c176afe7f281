# SPDX-License-Identifier: GPL-3.0-or-later
"""One function for each capability that differs between Blender versions."""

from .interface import add_group_input, add_group_output, hide_in_modifier, modifier_input, set_modifier_input
from .mesh import read_positions, write_positions
from .nodes import enabled_socket

__all__ = (
    "add_group_input",
    "add_group_output",
    "enabled_socket",
    "hide_in_modifier",
    "modifier_input",
    "read_positions",
    "set_modifier_input",
    "write_positions",
)
