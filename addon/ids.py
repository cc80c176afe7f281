# SPDX-License-Identifier: GPL-3.0-or-later
"""Every name that Blender, files and other rooms know us by."""

VERSION = "0.1.0"


class Operators:
    """``bl_idname`` of each operator."""

    DEFORMER_ADD = "sinew.deformer_add"
    DEFORMER_REMOVE = "sinew.deformer_remove"
    HANDLE_ADD = "sinew.handle_add"
    HANDLE_REMOVE = "sinew.handle_remove"
    BIND = "sinew.bind"
    UNBIND = "sinew.unbind"
    APPLY = "sinew.apply"
    SELECT_PROBLEMS = "sinew.select_problems"
    SELECT_HANDLE = "sinew.select_handle"


class Datablocks:
    """Names of datablocks we make; a leading dot hides them from Blender's menus."""

    NODE_GROUP = ".Sinew"
    PROXY_VIEWPORT = ".Sinew Viewport"
    PROXY_RENDER = ".Sinew Render"
    REST = ".Sinew Rest"
    MODIFIER = "Sinew"


class Keys:
    """Custom properties on Blender's data."""

    GROUP_VERSION = "sinew_group_version"
    KEEP = "sinew_keep_evaluated"
    REST_TOKEN = "sinew_token"
    REST_GROUPS = "sinew_groups"


class Inputs:
    """Inputs of the shared node group, by the name the modifier shows."""

    PROXY_VIEWPORT = "Viewport Shape"
    PROXY_RENDER = "Render Shape"
    MASK = "Mask"
    INCOMING = "Incoming Attribute"
    INDEX = "Index Attribute"
