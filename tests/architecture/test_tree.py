# SPDX-License-Identifier: GPL-3.0-or-later
"""This checkout keeps the rules; the other files test that an offence against each rule is found."""

from collections.abc import Callable
from pathlib import Path

import pytest

from . import layers, links, native_layers, registry, security, sources
from .counts import COUNTS, Count
from .tree import ROOT, files, listed

MODULES = (native_layers, layers, registry, security, sources, links)
RULES = [
    rule
    for module in MODULES
    for name, rule in vars(module).items()
    if name.endswith("_offences") and not name.startswith("_")
]


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.__name__)
def test_no_offence_in_this_tree(rule: Callable[[Path], list[str]]) -> None:
    offences = rule(ROOT)
    assert not offences, listed(offences)


def test_there_is_something_to_find_offences_in() -> None:
    assert list(files(ROOT, "native", ".cpp"))
    assert list(files(ROOT, "addon", ".py"))
    assert len(RULES) == 14
    assert registry.rows(ROOT)
    assert len(list(sources.sources(ROOT))) > 20
    assert sum(len(list(links.links(page))) for page in files(ROOT, ".", ".md")) > 30


@pytest.mark.parametrize("count", COUNTS, ids=lambda count: count.name)
def test_no_count_passes_its_limit(count: Count) -> None:
    now = count.find()
    assert now <= count.limit, f"{count.name}: {now:g}, at most {count.limit:g}"
