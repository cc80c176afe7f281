# SPDX-License-Identifier: GPL-3.0-or-later
"""This checkout keeps the rules; the other files test that an offence against each rule is found."""

from collections.abc import Callable
from pathlib import Path

import pytest

from .layers import addon_offences
from .links import link_offences, links
from .native_layers import native_offences
from .registry import registry_offences, rows
from .security import security_offences
from .sources import (
    class_name_offences,
    door_plate_offences,
    former_name_offences,
    licence_offences,
    size_offences,
    sources,
    system_offences,
    word_offences,
)
from .tree import ROOT, files, listed

RULES = (
    native_offences,
    addon_offences,
    registry_offences,
    security_offences,
    licence_offences,
    size_offences,
    word_offences,
    former_name_offences,
    system_offences,
    class_name_offences,
    door_plate_offences,
    link_offences,
)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.__name__)
def test_no_offence_in_this_tree(rule: Callable[[Path], list[str]]) -> None:
    offences = rule(ROOT)
    assert not offences, listed(offences)


def test_there_is_something_to_find_offences_in() -> None:
    assert list(files(ROOT, "native", ".cpp"))
    assert list(files(ROOT, "addon", ".py"))
    assert rows(ROOT)
    assert len(list(sources(ROOT))) > 20
    assert sum(len(list(links(page))) for page in files(ROOT, ".", ".md")) > 30
