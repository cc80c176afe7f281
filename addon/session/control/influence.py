# SPDX-License-Identifier: GPL-3.0-or-later
"""How far the points of a target follow parts of a control."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Influence:
    """The sum (n,) of the weights of some ``vertices`` of a control; the points ``outside`` of it."""

    vertices: tuple[int, ...]
    values: np.ndarray
    outside: np.ndarray
