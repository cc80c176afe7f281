# SPDX-License-Identifier: GPL-3.0-or-later
"""All identifiers that Blender, files and other rooms use for parts of Sinew."""

VERSION = "0.1.0"


class Operators:
    """``bl_idname`` of each operator."""

    DEFORMER_ADD = "sinew.deformer_add"
    DEFORMER_REMOVE = "sinew.deformer_remove"
    CAGE_ADD = "sinew.cage_add"
    CAGE_REST = "sinew.cage_set_rest"
    CAGE_FACES = "sinew.cage_faces"
    CAGE_FLIP = "sinew.cage_flip"
    CAGE_OUTSIDE = "sinew.cage_outside_follow"
    SETTINGS_SHARE = "sinew.settings_share"
    LATTICE_ADD = "sinew.lattice_add"
    LATTICE_REST = "sinew.lattice_set_rest"
    WIRE_ADD = "sinew.wire_add"
    WIRE_DRAW = "sinew.wire_draw"
    TOOL_ADD = "sinew.tool_add"
    TOOL_STOP = "sinew.tool_stop"
    TOOL_DRAG = "sinew.tool_drag"
    ROW_REMOVE = "sinew.control_remove"
    ROW_REST = "sinew.control_set_rest"
    HANDLE_ADD = "sinew.handle_add"
    POINT_ADD = "sinew.point_add"
    HANDLE_REMOVE = "sinew.handle_remove"
    CONTROL_NEW = "sinew.control_new"
    CONTROL_EDIT = "sinew.control_edit"
    POSE_RESET = "sinew.reset_pose"
    POSE_KEY = "sinew.key_pose"
    DRIVE = "sinew.drive_by_bone"
    BIND = "sinew.bind"
    UNBIND = "sinew.unbind"
    CANCEL = "sinew.cancel"
    WATCH = "sinew.watch"
    APPLY = "sinew.apply"
    SELECT_PROBLEMS = "sinew.select_problems"
    SELECT_DISTORTED = "sinew.select_distorted"
    SELECT_HANDLE = "sinew.select_handle"
    DEFORMER_MOVE = "sinew.deformer_move"
    HANDLE_MOVE = "sinew.handle_move"
    HANDLE_MIRROR = "sinew.handle_mirror"
    HANDLE_STAND = "sinew.handle_stand"
    KEY_ADD = "sinew.key_add"
    KEY_REMOVE = "sinew.key_remove"
    KEY_MOVE = "sinew.key_move"
    KEY_JUMP = "sinew.key_jump"
    REPAIR = "sinew.repair"
    PART_REGIONS = "sinew.part_regions"
    REFINE = "sinew.refine"
    ARMATURE_OFF = "sinew.armature_off"
    KEEP_INSIDE = "sinew.keep_inside"
    GRAB_REGION = "sinew.grab_region"
    DRAG = "sinew.drag"
    DRAG_PRESS = "sinew.drag_press"
    DRAG_START = "sinew.drag_start"
    CONTROL_DRAG = "sinew.control_drag"
    REACH_DRAG = "sinew.reach_drag"
    SILHOUETTE_SKETCH = "sinew.silhouette_sketch"
    PUPPET_POSE = "sinew.puppet_pose"
    PUPPET_PIN = "sinew.puppet_pin"
    PUPPET_RIG = "sinew.puppet_rig"
    BAKE = "sinew.bake"
    UNBAKE = "sinew.unbake"
    BAKE_FIND = "sinew.bake_find"
    TRANSFER = "sinew.transfer_deformation"
    MORPH = "sinew.morph"
    CURVE_EDIT = "sinew.curve_edit"
    GRID_NEW = "sinew.grid_new"
    HELP = "sinew.help"
    REPORT_RENDERS = "sinew.report_renders"
    CHECK_INSTALLATION = "sinew.check_installation"
    TASK_START = "sinew.start_task"
    METHOD_USE = "sinew.use_method"
    ALL_TASKS = "sinew.all_tasks"
    CHOOSE_METHOD = "sinew.choose_method"
    PRESET_ADD = "sinew.preset_add"
    PRESET_APPLY = "sinew.preset_apply"
    TEMPLATE_USE = "sinew.use_template"
    TRY_IT = "sinew.try_it"
    TRY_BACK = "sinew.try_back"


class Menus:
    """``bl_idname`` of the menus that are called by name."""

    EDIT_MESH = "SINEW_MT_edit_mesh"
    OBJECT = "SINEW_MT_object"
    PIE = "SINEW_MT_pie"
    ADD_REGION = "SINEW_MT_add_region"
    HANDLE = "SINEW_MT_handle"
    CAGE = "SINEW_MT_cage"
    LATTICE = "SINEW_MT_lattice"
    WIRES = "SINEW_MT_wires"
    TOOLS = "SINEW_MT_tools"
    DEFORMER = "SINEW_MT_deformer"
    MANUAL = "SINEW_MT_manual"
    MANUAL_METHODS = "SINEW_MT_manual_methods"
    PROBLEMS = "SINEW_MT_problems"
    OTHER_NAMES = "SINEW_MT_other_names"
    TRY_IT = "SINEW_MT_try_it"
    LEARNED_NAMES = "SINEW_MT_learned_names"
    OF_TASK = "SINEW_MT_task_{}"  # with the id of the task
    FOR_GROUPS = {  # by the role of the region that a vertex group becomes
        "HANDLE": "SINEW_MT_handle_of_group",
        "FIXED": "SINEW_MT_fixed_of_group",
        "SUPPORT": "SINEW_MT_support_of_group",
    }


class Panels:
    """``bl_idname`` of the panels that are called by name."""

    PRESETS = "SINEW_PT_presets"


class Datablocks:
    """Names of the datablocks that Sinew makes. A leading dot hides them in Blender's menus."""

    NODE_GROUP = ".Sinew"
    PROXY_VIEWPORT = ".Sinew Viewport"
    PROXY_RENDER = ".Sinew Render"
    REST = ".Sinew Rest"
    CURVE = ".Sinew Curve"
    MODIFIER = "Sinew"
    SHAPE_KEY = "Sinew"
    BASIS = "Basis"


class Keys:
    """Names of the custom properties that Sinew stores on Blender's data."""

    GROUP_VERSION = "sinew_group_version"
    GROUP_POINT_TYPE = "sinew_group_kind"
    KEEP = "sinew_keep_evaluated"
    SHAPE = "sinew_shape"
    MADE_BASIS = "sinew_made_basis"
    CURVE = "sinew_curve"
    GRID_REST = "sinew_grid_rest"
    CAGE_ORIGIN = "sinew_cage"
    TRIED = "sinew_tried"
    REST_TOKEN = "sinew_token"
    REST_LATTICE = "sinew_resolution"
    REST_INTERPOLATION = "sinew_interpolation"
    REST_GROUPS = "sinew_groups"
    REST_LOST = "sinew_lost_groups"
    REST_POINT_TYPE = "sinew_kind"
    REST_STRUCTURE = "sinew_structure"
    REST_POSE = "sinew_pose"


class Inputs:
    """Inputs of the shared node groups, by the names that the modifier shows."""

    PROXY_VIEWPORT = "Viewport Shape"
    PROXY_RENDER = "Render Shape"
    MASK = "Mask"
    INCOMING = "Incoming Attribute"
    INDEX = "Index Attribute"
