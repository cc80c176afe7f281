# SPDX-License-Identifier: GPL-3.0-or-later
"""What happens when Sinew refuses: the artist reads why, and the operator ends without a change."""

from collections.abc import Callable
from functools import wraps

from bpy.types import Context

from ..core.errors import SinewError


def refusing(run: Callable) -> Callable:
    """A method of an operator, ``(context, ...)``, that reports a ``SinewError`` and then is cancelled.

    Not for ``invoke`` and ``modal``: Blender counts the named arguments of those.
    """

    @wraps(run)
    def reporting(self, context: Context, *further, **named) -> set[str]:
        try:
            return run(self, context, *further, **named)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}

    return reporting
