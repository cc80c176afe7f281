# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the curve of a parameter, or restore its default."""

from bpy.props import BoolProperty, StringProperty
from bpy.types import Context, Operator

from ...core.errors import OptionError
from ...core.labels import label_of
from ...core.methods import Curve
from ...ids import Operators
from ...properties import field
from ...session.datablocks import references
from ..arguments import once
from ..offered import OnDeformer
from ..reporting import reports_errors
from ..target import target_of


class SINEW_OT_curve_edit(OnDeformer, Operator):
    """Draw this curve by moving its points, starting with the current curve"""

    bl_idname = Operators.CURVE_EDIT
    bl_label = "Draw Curve"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    parameter: field(StringProperty).named("Parameter", "Give the identifier of the curve to draw")
    reset: once(BoolProperty).named("Reset", "Discard the drawn curve and use the default")

    @classmethod
    def description(cls, _context: Context, properties: "SINEW_OT_curve_edit") -> str:
        """The tooltip, which depends on what the button does."""
        return "Discard the drawn curve and use the default" if properties.reset else cls.__doc__

    @reports_errors
    def execute(self, context: Context) -> set[str]:
        deformer = target_of(context).sinew.active
        curves = {
            row.id: (values, row)
            for method, values in deformer.methods
            for row in method.references
            if isinstance(row, Curve)
        }
        if self.parameter not in curves:
            names = ", ".join(curves) or "none"
            raise OptionError(
                f"{label_of(deformer.definition)} has no curve '{self.parameter}' - its curves: {names}"
            )
        values, curve = curves[self.parameter]
        if self.reset:
            references.reset_curve(values, curve.id)
        else:
            references.edit_curve(values, curve)
        return {"FINISHED"}
