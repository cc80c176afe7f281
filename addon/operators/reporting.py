# SPDX-License-Identifier: GPL-3.0-or-later
"""How operators report errors: the artist reads the message, and the operator is cancelled."""

from collections.abc import Callable
from functools import wraps

from bpy.types import Context

from ..core.errors import SinewError


def reports_errors(run: Callable) -> Callable:
    """Decorate a method ``(self, context, ...)`` of an operator: a ``SinewError`` is reported and cancels it.

    Do not use it for ``invoke`` and ``modal``, since Blender counts their arguments.
    """

    @wraps(run)
    def reporting(self, context: Context, *further, **named) -> set[str]:
        try:
            return run(self, context, *further, **named)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}

    return reporting
