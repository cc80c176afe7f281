# SPDX-License-Identifier: GPL-3.0-or-later
"""A click on a row of a list selects the control of the row, as the panel promises."""

from contextlib import suppress

import bpy

from ...core.errors import SinewError
from ...properties import SinewDeformer, row_at
from ..controls.cage import show_only
from ..target import target_of
from .handle import choose_handle


def follow(deformer: SinewDeformer, rows: str) -> None:
    """Select the control of the active row. In Edit Mode the selection is the artist's own."""
    context, obj = bpy.context, deformer.id_data
    if target_of(context) != obj or obj.mode == "EDIT":
        return
    if rows == "handles":
        with suppress(SinewError):  # the row shows by itself that its control is lost
            choose_handle(context, obj, deformer)
    else:
        row = row_at(deformer.controls, deformer.active_control)
        if row is not None and row.object is not None and context.mode == "OBJECT":
            show_only(context, obj, row.object)
