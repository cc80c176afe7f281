# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of two sides. ``operators/test_mirror.py`` in Blender holds them equal to Blender's own answers."""

import pytest

from sinew.core.sides import Side, flip, side_of


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("Hand.L", "Hand.R"),
        ("hand_l", "hand_r"),
        ("hand-L", "hand-R"),
        ("hand l", "hand r"),
        ("L.Hand", "R.Hand"),
        ("l_hand", "r_hand"),
        ("L-Hand", "R-Hand"),
        ("LeftHand", "RightHand"),
        ("LEFTHAND", "RIGHTHAND"),
        ("handleft", "handright"),
        ("Hand.Left", "Hand.Right"),
        ("HandLEFT", "HandRIGHT"),
        ("Hand.L.001", "Hand.R.001"),
        ("leftHand.012", "rightHand.012"),
        ("Größe.L", "Größe.R"),
    ],
)
def test_sides_flip_both_ways(left: str, right: str):
    assert flip(left) == right
    assert flip(right) == left
    assert side_of(left) is Side.LEFT
    assert side_of(right) is Side.RIGHT


@pytest.mark.parametrize(
    "name", ["", "L", ".L", "L.", "Head", "Ball", "shell", "Hand.Lx", "Hand.001", "xleftx", "L.001", "left"]
)
def test_a_name_without_a_side_has_no_counterpart(name: str):
    assert flip(name) == ""
    assert side_of(name) is None


def test_the_suffix_counts_before_the_prefix():
    assert flip("L.Hand.R") == "L.Hand.L"
    assert flip("L.Left") == "R.Left"
