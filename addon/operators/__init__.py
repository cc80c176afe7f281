# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators, which are the buttons and menu entries of Sinew."""

from bpy.utils import register_classes_factory

from . import entering
from .apply import SINEW_OT_apply
from .bake import SINEW_OT_bake, SINEW_OT_unbake
from .bind import SINEW_OT_bind, SINEW_OT_unbind
from .cage import (
    SINEW_OT_cage_add,
    SINEW_OT_cage_faces,
    SINEW_OT_cage_flip,
    SINEW_OT_cage_outside_follow,
    SINEW_OT_cage_set_rest,
)
from .cancel import SINEW_OT_cancel, SINEW_OT_watch
from .check import SINEW_OT_check_installation
from .control import SINEW_OT_control_new
from .curve import SINEW_OT_curve_edit
from .deformer import SINEW_OT_deformer_add, SINEW_OT_deformer_remove
from .drag import SINEW_OT_drag, surface_under
from .grab_region import SINEW_OT_grab_region
from .grid import SINEW_OT_grid_new
from .handle import (
    SINEW_OT_handle_add,
    SINEW_OT_handle_remove,
    SINEW_OT_keep_inside,
    SINEW_OT_select_handle,
)
from .help import PAGES, SINEW_OT_help
from .key import SINEW_OT_key_add, SINEW_OT_key_jump, SINEW_OT_key_move, SINEW_OT_key_remove
from .lattice import SINEW_OT_lattice_add, SINEW_OT_lattice_set_rest
from .mirror import SINEW_OT_handle_mirror
from .modal.ring import draw_line, ring
from .morph import SINEW_OT_morph
from .move import SINEW_OT_deformer_move, SINEW_OT_handle_move
from .point import SINEW_OT_point_add
from .preset import SINEW_OT_preset_add, SINEW_OT_preset_apply, preset_folder
from .puppet import SINEW_OT_puppet_pin, SINEW_OT_puppet_pose, SINEW_OT_puppet_rig
from .repair import SINEW_OT_armature_off, SINEW_OT_part_regions, SINEW_OT_refine, SINEW_OT_repair
from .report_renders import SINEW_OT_report_renders
from .rows import SINEW_OT_control_remove, SINEW_OT_control_set_rest
from .select_distorted import SINEW_OT_select_distorted
from .select_problems import SINEW_OT_select_problems
from .sharing import SINEW_OT_settings_share
from .silhouette_sketch import SINEW_OT_silhouette_sketch
from .stand import SINEW_OT_handle_stand
from .target import explain_no_target, target_of
from .tool_drag import SINEW_OT_tool_drag
from .tools import SINEW_OT_tool_add, SINEW_OT_tool_stop
from .transfer import SINEW_OT_transfer_deformation
from .waiting import redraw_panels
from .wire_draw import SINEW_OT_wire_draw
from .wires import SINEW_OT_wire_add

__all__ = (
    "PAGES",
    "SINEW_OT_drag",
    "draw_line",
    "entering",
    "explain_no_target",
    "preset_folder",
    "redraw_panels",
    "register",
    "ring",
    "surface_under",
    "target_of",
    "unregister",
)

register, unregister = register_classes_factory(
    (
        SINEW_OT_deformer_add,
        SINEW_OT_report_renders,
        SINEW_OT_deformer_remove,
        SINEW_OT_deformer_move,
        SINEW_OT_cage_add,
        SINEW_OT_cage_set_rest,
        SINEW_OT_cage_flip,
        SINEW_OT_cage_faces,
        SINEW_OT_cage_outside_follow,
        SINEW_OT_settings_share,
        SINEW_OT_lattice_add,
        SINEW_OT_lattice_set_rest,
        SINEW_OT_wire_add,
        SINEW_OT_tool_add,
        SINEW_OT_tool_stop,
        SINEW_OT_tool_drag,
        SINEW_OT_wire_draw,
        SINEW_OT_control_remove,
        SINEW_OT_control_set_rest,
        SINEW_OT_handle_add,
        SINEW_OT_point_add,
        SINEW_OT_handle_remove,
        SINEW_OT_handle_mirror,
        SINEW_OT_handle_move,
        SINEW_OT_handle_stand,
        SINEW_OT_key_add,
        SINEW_OT_key_remove,
        SINEW_OT_key_move,
        SINEW_OT_key_jump,
        SINEW_OT_control_new,
        SINEW_OT_select_handle,
        SINEW_OT_bind,
        SINEW_OT_unbind,
        SINEW_OT_cancel,
        SINEW_OT_watch,
        SINEW_OT_apply,
        SINEW_OT_bake,
        SINEW_OT_unbake,
        SINEW_OT_transfer_deformation,
        SINEW_OT_morph,
        SINEW_OT_select_problems,
        SINEW_OT_grab_region,
        SINEW_OT_drag,
        SINEW_OT_silhouette_sketch,
        SINEW_OT_puppet_pose,
        SINEW_OT_puppet_pin,
        SINEW_OT_puppet_rig,
        SINEW_OT_repair,
        SINEW_OT_part_regions,
        SINEW_OT_refine,
        SINEW_OT_armature_off,
        SINEW_OT_keep_inside,
        SINEW_OT_select_distorted,
        SINEW_OT_curve_edit,
        SINEW_OT_grid_new,
        SINEW_OT_help,
        SINEW_OT_check_installation,
        SINEW_OT_preset_add,
        SINEW_OT_preset_apply,
    )
)
