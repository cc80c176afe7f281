# SPDX-License-Identifier: GPL-3.0-or-later
"""How operators report: in the language of the interface; an error cancels the operator."""

from collections.abc import Callable
from functools import wraps

from bpy.types import Context

from .. import compat
from ..core.errors import SinewError


class Reports:
    """Mixin for an operator that reports in the language of the interface."""

    def tell(self, levels: set[str], text: str) -> None:
        """Report. Blender looks up ``report`` itself past any method of that name."""
        self.report(levels, compat.told(text))


def reports_errors(run: Callable) -> Callable:
    """Decorate a method ``(self, context, ...)`` of an operator: a ``SinewError`` is reported and cancels it.

    Do not use it for ``invoke`` and ``modal``, since Blender counts their arguments.
    """

    @wraps(run)
    def reporting(self, context: Context, *further, **named) -> set[str]:
        try:
            return run(self, context, *further, **named)
        except SinewError as error:
            self.tell({"ERROR"}, str(error))
            return {"CANCELLED"}

    return reporting
