# SPDX-License-Identifier: GPL-3.0-or-later
"""Reset Pose and Key Pose: all controls of a deformer at once, whatever kind they are of."""

from collections.abc import Sequence

from bpy.props import BoolProperty
from bpy.types import Context, Operator

from ...ids import Operators
from ...session.actions import pose
from ..arguments import once
from ..offered import OnLiveDeformer
from ..reporting import reports_errors
from ..target import object_mode, target_of


class SINEW_OT_reset_pose(OnLiveDeformer, Operator):
    """Bring all controls of the deformer back to rest, with their points and the paths of clay tools.

    Auto Keying keys them there
    """

    bl_idname = Operators.POSE_RESET
    bl_label = "Reset Pose"

    selected: once(BoolProperty).named("Selected", "Bring back the controls that are selected, and no others")

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj, keys = target_of(context), context.scene.tool_settings.use_keyframe_insert_auto
        with object_mode(context, context.object):
            count, posed = pose.reset(obj, obj.sinew.active, self.selected, keys)
        if posed:
            self.tell(
                {"WARNING"}, f"Something else poses {_named(posed)}: a parent, a constraint or a modifier"
            )
        else:
            self.tell({"INFO"}, f"{_controls(count)} at rest")
        return {"FINISHED"}


class SINEW_OT_key_pose(OnLiveDeformer, Operator):
    """Key all controls of the deformer where they are, also those that Mirror moves"""

    bl_idname = Operators.POSE_KEY
    bl_label = "Key Pose"

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        count, edited = pose.key_all(obj, obj.sinew.active)
        if edited:
            self.tell({"WARNING"}, f"The points of {_named(edited)} are not keyed - pose them by shape keys")
        else:
            self.tell({"INFO"}, f"{_controls(count)} keyed")
        return {"FINISHED"}


def _controls(count: int) -> str:
    return "1 control is" if count == 1 else f"{count} controls are"


def _named(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more"
