# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators, which are the buttons and menu entries of Sinew."""

from bpy.utils import register_classes_factory

from ..properties import deformer as settings
from . import entering as entering
from .animation.bake import SINEW_OT_bake, SINEW_OT_bake_find, SINEW_OT_unbake
from .animation.drive import SINEW_OT_drive_by_bone
from .animation.key import SINEW_OT_key_add, SINEW_OT_key_jump, SINEW_OT_key_move, SINEW_OT_key_remove
from .animation.morph import SINEW_OT_morph
from .animation.transfer import SINEW_OT_transfer_deformation
from .controls.cage import (
    SINEW_OT_cage_add,
    SINEW_OT_cage_faces,
    SINEW_OT_cage_flip,
    SINEW_OT_cage_outside_follow,
    SINEW_OT_cage_set_rest,
)
from .controls.curve import SINEW_OT_curve_edit
from .controls.grid import SINEW_OT_grid_new
from .controls.lattice import SINEW_OT_lattice_add, SINEW_OT_lattice_set_rest
from .controls.pose import SINEW_OT_key_pose, SINEW_OT_reset_pose
from .controls.tools import SINEW_OT_tool_add, SINEW_OT_tool_stop
from .controls.wires import SINEW_OT_wire_add
from .deformer.apply import SINEW_OT_apply
from .deformer.bind import SINEW_OT_bind, SINEW_OT_unbind
from .deformer.cancel import SINEW_OT_cancel, SINEW_OT_watch
from .deformer.check import SINEW_OT_check_installation
from .deformer.deformer import SINEW_OT_deformer_add, SINEW_OT_deformer_remove
from .deformer.fast_subdivision import SINEW_OT_fast_subdivision
from .deformer.help import PAGES as PAGES, SINEW_OT_help, page_of as page_of
from .deformer.move import SINEW_OT_deformer_move, SINEW_OT_handle_move
from .deformer.preset import (
    SINEW_OT_preset_add,
    SINEW_OT_preset_apply,
    SINEW_OT_use_template,
    preset_folder as preset_folder,
    template_refusal as template_refusal,
)
from .deformer.remesh import (
    SINEW_OT_decimate,
    SINEW_OT_remesh,
    SINEW_OT_remesh_semi_regular,
    SINEW_OT_remove_needles,
)
from .deformer.repair import (
    SINEW_OT_armature_off,
    SINEW_OT_cure,
    SINEW_OT_part_regions,
    SINEW_OT_refine,
    SINEW_OT_repair,
    SINEW_OT_use_factor,
)
from .deformer.report_renders import SINEW_OT_report_renders
from .deformer.select_distorted import SINEW_OT_select_distorted
from .deformer.select_problems import SINEW_OT_select_problems
from .deformer.sharing import SINEW_OT_settings_share
from .deformer.survey import SINEW_OT_diagnose, SINEW_OT_measure_curvature, SINEW_OT_select_unusual
from .handles import clicking
from .handles.control import SINEW_OT_control_edit, SINEW_OT_control_new
from .handles.handle import (
    SINEW_OT_handle_add,
    SINEW_OT_handle_remove,
    SINEW_OT_keep_inside,
    SINEW_OT_select_handle,
)
from .handles.mirror import SINEW_OT_handle_mirror
from .handles.point import SINEW_OT_point_add
from .handles.rows import SINEW_OT_control_remove, SINEW_OT_control_set_rest
from .handles.stand import SINEW_OT_handle_stand
from .modal.ring import draw_line as draw_line, ring as ring
from .modal.shell import ViewportTool as ViewportTool
from .target import explain_no_target as explain_no_target, target_of as target_of
from .tasks.refusals import (
    choice_refusal as choice_refusal,
    method_refusal as method_refusal,
    task_refusal as task_refusal,
    tasks_beside as tasks_beside,
)
from .tasks.start import SINEW_OT_start_task, SINEW_OT_use_method
from .tasks.try_it import SINEW_OT_try_back, SINEW_OT_try_it
from .tools.control_drag import SINEW_OT_control_drag
from .tools.drag import AROUND as AROUND, HANDLE as HANDLE, SINEW_OT_drag, handle_sizes as handle_sizes
from .tools.grab_region import SINEW_OT_grab_region
from .tools.puppet import SINEW_OT_puppet_pin, SINEW_OT_puppet_pose, SINEW_OT_puppet_rig
from .tools.reach_drag import SINEW_OT_reach_drag
from .tools.silhouette_sketch import SINEW_OT_silhouette_sketch
from .tools.sinew_drag import SINEW_OT_drag_press, SINEW_OT_drag_start, makes_handles as makes_handles
from .tools.tool_drag import SINEW_OT_tool_drag
from .tools.under_mouse import bone_under as bone_under, surface_under as surface_under
from .tools.wire_draw import SINEW_OT_wire_draw
from .waiting import redraw_panels as redraw_panels

_CLASSES = (
    SINEW_OT_start_task,
    SINEW_OT_use_method,
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
    SINEW_OT_reset_pose,
    SINEW_OT_key_pose,
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
    SINEW_OT_control_edit,
    SINEW_OT_select_handle,
    SINEW_OT_bind,
    SINEW_OT_unbind,
    SINEW_OT_cancel,
    SINEW_OT_watch,
    SINEW_OT_apply,
    SINEW_OT_bake,
    SINEW_OT_unbake,
    SINEW_OT_bake_find,
    SINEW_OT_transfer_deformation,
    SINEW_OT_morph,
    SINEW_OT_drive_by_bone,
    SINEW_OT_select_problems,
    SINEW_OT_grab_region,
    SINEW_OT_drag,
    SINEW_OT_drag_press,
    SINEW_OT_drag_start,
    SINEW_OT_control_drag,
    SINEW_OT_reach_drag,
    SINEW_OT_silhouette_sketch,
    SINEW_OT_puppet_pose,
    SINEW_OT_puppet_pin,
    SINEW_OT_puppet_rig,
    SINEW_OT_repair,
    SINEW_OT_cure,
    SINEW_OT_part_regions,
    SINEW_OT_refine,
    SINEW_OT_fast_subdivision,
    SINEW_OT_armature_off,
    SINEW_OT_keep_inside,
    SINEW_OT_use_factor,
    SINEW_OT_select_distorted,
    SINEW_OT_diagnose,
    SINEW_OT_select_unusual,
    SINEW_OT_measure_curvature,
    SINEW_OT_remesh,
    SINEW_OT_decimate,
    SINEW_OT_remesh_semi_regular,
    SINEW_OT_remove_needles,
    SINEW_OT_curve_edit,
    SINEW_OT_grid_new,
    SINEW_OT_help,
    SINEW_OT_check_installation,
    SINEW_OT_preset_add,
    SINEW_OT_preset_apply,
    SINEW_OT_use_template,
    SINEW_OT_try_it,
    SINEW_OT_try_back,
)

# Tooltips have one sentence, the first one of the docstring.
for _cls in _CLASSES:
    _cls.bl_description = " ".join(_cls.__doc__.split()).partition(". ")[0]

_register, _unregister = register_classes_factory(_CLASSES)


def register() -> None:
    _register()
    settings.add_click_observer(clicking.follow)


def unregister() -> None:
    settings.remove_click_observer(clicking.follow)
    _unregister()
