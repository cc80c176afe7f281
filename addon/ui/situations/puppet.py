# SPDX-License-Identifier: GPL-3.0-or-later
"""An armature: drag its bones, pin them, and let a skin follow them."""

from bpy.types import Context, Object, UILayout

from ...ids import Operators
from ...operators import target_of
from ...session.targets import targets
from ..layouts import Button, draw_pair, invoking
from ..places import active_deformer
from ..pose import draw_drag, draw_reset
from ..text import draw_text

_PINS = (
    Button(Operators.PUPPET_PIN, "Pin", "PINNED", (("action", "PIN"),)),
    Button(Operators.PUPPET_PIN, "Unpin", "UNPINNED", (("action", "RELEASE"),)),
)
_SKIN = Button(Operators.PUPPET_RIG, "Skin by Bones...", "MOD_ARMATURE")


def is_there(context: Context) -> bool:
    """Whether bones are posed; outside of Pose Mode, whether an armature is all that is selected."""
    obj = context.object
    if obj is None or not targets.has_bones(obj) or obj.library is not None:
        return False
    return obj.mode == "POSE" or (obj.mode == "OBJECT" and target_of(context) is None)


def page(_context: Context) -> str:
    """How figures are posed by their bones."""
    return "pose-by-bones"


def draw(context: Context, layout: UILayout) -> None:
    """Draw the tools of a figure."""
    armature = context.object
    if armature.mode == "POSE":
        _draw_posing(context, invoking(layout.column()), armature)
    else:
        layout.label(text=armature.name, icon="OUTLINER_OB_ARMATURE")
        large = layout.column()
        large.scale_y = 1.5
        large.operator("object.mode_set", text="Pose Mode", icon="POSE_HLT").mode = "POSE"
    _SKIN.draw(invoking(layout.column()))


def _draw_posing(context: Context, layout: UILayout, armature: Object) -> None:
    active = armature.data.bones.active
    text = armature.name if active is None else f"{armature.name}: {active.name}"
    draw_text(context, layout, text, "ARMATURE_DATA")
    large = layout.column()
    large.scale_y = 1.5
    draw_drag(large, "BONES")
    draw_pair(context, layout, _PINS)
    if active_deformer(context) is not None:
        draw_reset(layout)
    pinned = [bone.name for bone in armature.pose.bones if bone.sinew.pin]
    if pinned:
        draw_text(context, layout, f"Pinned: {', '.join(pinned)}", "PINNED")
    layout.prop(context.scene.sinew.drag, "balance")
