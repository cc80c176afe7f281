# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render shows of a deformer that is not solved in it: the shape that the viewport shows.

That is so if Live is off, if the native module is missing, and if the control is lost since the file was
opened.
"""

from dataclasses import replace

from ..datablocks.shapes import shapes
from ..state.evaluation import Evaluation


def show_viewport_shape(evaluation: Evaluation) -> None:
    """In a render, show what the viewport shows. Where other vertices enter in renders, the last shape stays.

    This only writes an array.
    """
    if not evaluation.in_viewport:
        shapes.render_as_shown(evaluation.deformer, evaluation.depsgraph.scene)


def while_not_live(evaluation: Evaluation) -> Evaluation | None:
    """What to solve while Live is off: mostly nothing, as the last shape stays.

    If other vertices enter in renders, these are solved for the poses that the viewport shows. A frame that
    switches Live off, while the viewport is at one where it is on, keeps the shape of the frame before.
    """
    deformer = evaluation.deformer
    if evaluation.in_viewport or deformer.live:
        return None
    if shapes.render_as_shown(deformer, evaluation.depsgraph.scene) or not evaluation.session.poses:
        return None
    return replace(evaluation, control=[None] * len(evaluation.control))
