# SPDX-License-Identifier: GPL-3.0-or-later
"""One function for each capability that differs between Blender versions."""

from .animation import action_curves as action_curves, remove_action_curve as remove_action_curve
from .bones import (
    is_bone_selected as is_bone_selected,
    is_bone_visible as is_bone_visible,
    select_bone as select_bone,
)
from .drawing import set_text_size as set_text_size, smooth_colour_shader as smooth_colour_shader
from .interface import (
    add_group_input as add_group_input,
    add_group_output as add_group_output,
    has_group_input as has_group_input,
    hide_in_modifier as hide_in_modifier,
    modifier_input as modifier_input,
    modifier_inputs as modifier_inputs,
    rename_attribute_inputs as rename_attribute_inputs,
    set_modifier_input as set_modifier_input,
)
from .layout import (
    close_popups as close_popups,
    draw_keymap_item as draw_keymap_item,
    draw_progress as draw_progress,
    refresh_popup as refresh_popup,
    text_width as text_width,
)
from .libraries import is_placeholder as is_placeholder, session_key as session_key
from .mesh import (
    edge_creases as edge_creases,
    read_cloud as read_cloud,
    read_creases as read_creases,
    read_edges as read_edges,
    read_faces as read_faces,
    read_lattice as read_lattice,
    read_positions as read_positions,
    read_triangles as read_triangles,
    write_creases as write_creases,
    write_lattice as write_lattice,
    write_positions as write_positions,
)
from .modifiers import move_modifier as move_modifier
from .nodes import enabled_socket as enabled_socket
from .paths import beside_the_file as beside_the_file
from .shape_keys import read_key as read_key, remove_data as remove_data, write_key as write_key
from .translation import told as told
