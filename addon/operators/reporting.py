# SPDX-License-Identifier: GPL-3.0-or-later
"""How operators report: in the language of the interface; an error cancels the operator."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps

from bpy.types import Context, Operator

from .. import compat
from ..core.errors import SinewError

_callers: list[Operator] = []  # operators that call another one at the moment, the last one innermost


@contextmanager
def reporting_for(caller: Operator) -> Iterator[None]:
    """Let their caller say what other operators report meanwhile, since Blender would show it to nobody."""
    _callers.append(caller)
    try:
        yield
    finally:
        _callers.remove(caller)


class Reports:
    """Mixin for an operator that reports in the language of the interface."""

    def tell(self, levels: set[str], text: str) -> None:
        """Report. Blender looks up ``report`` itself past any method of that name."""
        (_callers[-1] if _callers else self).report(levels, compat.told(text))


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
