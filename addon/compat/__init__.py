# SPDX-License-Identifier: GPL-3.0-or-later
"""One function for each capability that differs between Blender versions."""

from .animation import action_curves, remove_action_curve
from .bones import is_bone_selected, is_bone_visible, select_bone
from .drawing import set_text_size, smooth_colour_shader
from .interface import (
    add_group_input,
    add_group_output,
    has_group_input,
    hide_in_modifier,
    modifier_input,
    modifier_inputs,
    rename_attribute_inputs,
    set_modifier_input,
)
from .layout import close_popups, draw_keymap_item, draw_progress, refresh_popup, text_width
from .libraries import is_placeholder
from .mesh import (
    read_cloud,
    read_edges,
    read_faces,
    read_lattice,
    read_positions,
    read_triangles,
    write_lattice,
    write_positions,
)
from .modifiers import move_modifier
from .nodes import enabled_socket
from .shape_keys import read_key, remove_data, write_key
from .translation import told
