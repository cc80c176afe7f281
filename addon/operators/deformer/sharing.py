# SPDX-License-Identifier: GPL-3.0-or-later
"""Give all objects that a control moves the same settings, or another rest of it."""

from bpy.types import Context, Object, Operator

from ...ids import Operators
from ...properties import SinewDeformer
from ...session.actions import bind, rigging, sharing
from ...session.actions.controls.around import Target
from ..offered import OnDeformer
from ..reporting import reports_errors
from ..target import target_of
from ..waiting import BindingOperator


class BindsAll(BindingOperator):
    """Base of operators that change the controls of the active deformer, and bind all that they move again.

    By default, the controls rest as they are now.
    """

    def change(self, obj: Object, deformer: SinewDeformer) -> list[Target]:
        """Change them; the other deformers to bind, with their objects."""
        return sharing.set_rest(obj, deformer)

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        obj = target_of(context)
        deformer = obj.sinew.active
        others = self.change(obj, deformer)
        bind.bind(obj, deformer, wait)
        bound = [(deformer, None), *((row, rigging.try_bind(other, row, wait)) for other, row in others)]
        self.report_shared(bound, "")
        return {"FINISHED"}


class SINEW_OT_settings_share(OnDeformer, BindingOperator, Operator):
    """Give the other objects that the same cage, lattice, wires or tools move these settings: the method with
    its parameters, and Factor.

    Masks, painted groups and drawn curves stay as they are
    """

    bl_idname = Operators.SETTINGS_SHARE
    bl_label = "Copy to All Targets"

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            "" if sharing.sharing(target_of(context).sinew.active) else "The control moves no other object"
        )

    @reports_errors
    def run(self, context: Context, wait: bool) -> set[str]:
        others = sharing.share_settings(target_of(context).sinew.active)
        refused = [
            error
            for obj, deformer in others
            if not deformer.is_bound and (error := rigging.try_bind(obj, deformer, wait)) is not None
        ]
        if refused:
            self.tell({"WARNING"}, str(refused[0]))
        else:
            objects = "1 other object has" if len(others) == 1 else f"{len(others)} other objects have"
            self.tell({"INFO"}, f"{objects} these settings now")
        return {"FINISHED"}
