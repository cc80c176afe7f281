# SPDX-License-Identifier: GPL-3.0-or-later
from xml.etree import ElementTree

from .layers import ADDON_RANKS, INNER_RANKS
from .native_layers import NATIVE_RANKS
from .picture import PICTURE, draw
from .tree import ROOT


def test_the_picture_shows_every_room() -> None:
    shown = {"".join(node.itertext()) for node in ElementTree.fromstring(draw()).iter() if node.text}
    for room in (*ADDON_RANKS, *NATIVE_RANKS, *INNER_RANKS["session"]):
        assert room in shown


def test_the_picture_is_that_of_the_ranks() -> None:
    assert (ROOT / PICTURE).read_text(encoding="utf-8") == draw(), "renew it: tools/draw_architecture"
