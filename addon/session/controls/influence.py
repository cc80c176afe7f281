# SPDX-License-Identifier: GPL-3.0-or-later
"""How far the points of a target follow parts of a control."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Influence:
    """``values`` (n,): per point of the target, the sum of the weights of some ``vertices`` of a control.

    ``outside`` are the indices of the points that lie outside the control.
    """

    vertices: tuple[int, ...]
    values: np.ndarray
    outside: np.ndarray
