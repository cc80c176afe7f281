# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons."""

from bpy.utils import register_classes_factory

from .apply import SINEW_OT_apply
from .bind import SINEW_OT_bind, SINEW_OT_unbind
from .deformer import SINEW_OT_deformer_add, SINEW_OT_deformer_remove
from .handle import SINEW_OT_handle_add, SINEW_OT_handle_remove, SINEW_OT_select_handle
from .select_problems import SINEW_OT_select_problems
from .target import target_of

__all__ = ("register", "target_of", "unregister")

register, unregister = register_classes_factory(
    (
        SINEW_OT_deformer_add,
        SINEW_OT_deformer_remove,
        SINEW_OT_handle_add,
        SINEW_OT_handle_remove,
        SINEW_OT_select_handle,
        SINEW_OT_bind,
        SINEW_OT_unbind,
        SINEW_OT_apply,
        SINEW_OT_select_problems,
    )
)
