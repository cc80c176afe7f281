# SPDX-License-Identifier: GPL-3.0-or-later
"""Let Sinew refine a mesh in viewports, in place of its Subdivision modifier."""

from bpy.props import BoolProperty
from bpy.types import Context, Operator

from ...ids import Operators
from ...session.actions import fast_subdivision
from ..offered import OnDeformer
from ..reporting import reports_errors
from ..target import object_mode, target_of

_STOP = "Let the Subdivision modifier refine the mesh in viewports again"


class SINEW_OT_fast_subdivision(OnDeformer, Operator):
    """Let Sinew refine the mesh in viewports as its Subdivision modifier says, in less time"""

    bl_idname = Operators.FAST_SUBDIVISION
    bl_label = "Fast Subdivision"
    MESHES_ONLY = True

    stop: BoolProperty(name="Stop", description=_STOP, options={"SKIP_SAVE"})

    @classmethod
    def description(cls, _context: Context, properties: "SINEW_OT_fast_subdivision") -> str:
        """What the button does: it begins or ends."""
        return _STOP if properties.stop else cls.__doc__

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        obj = target_of(context)
        with object_mode(context, obj):
            if self.stop:
                if not fast_subdivision.end(obj):
                    return {"CANCELLED"}
                self.tell({"INFO"}, "Fast Subdivision has ended")
                return {"FINISHED"}
            by = fast_subdivision.begin(obj)
        self.tell({"INFO"}, f"Sinew refines as {by.name} says, which is for renders now")
        return {"FINISHED"}
