# SPDX-License-Identifier: GPL-3.0-or-later
from pathlib import Path

import pytest

from .links import link_offences
from .tree import grow

PAGE = "# One & all\n\n## Its part\n\n## Its part\n\n```\n# no heading\n[a](gone.md)\n```\n`[a](gone.md)`\n"


@pytest.mark.parametrize(
    "link",
    [
        "two.md",
        "two.md#its-part",
        "two.md#its-part-1",
        "two.md#one--all",
        "../methods/three.md",
        "images/a%20b.jpg",
        "#here",
        "https://example.org/gone.md#gone",
    ],
)
def test_good_link_is_left_alone(tmp_path: Path, link: str) -> None:
    tree = {
        "docs/manual/one.md": f"## Here\n[a]({link})",
        "docs/manual/two.md": PAGE,
        "docs/manual/images/a b.jpg": "",
        "docs/methods/three.md": "# Three",
    }
    assert link_offences(grow(tmp_path, tree)) == []


@pytest.mark.parametrize(
    ("link", "problem"),
    [
        ("gone.md", "does not exist"),
        ("images/gone.jpg", "does not exist"),
        ("two.md#gone", "is no heading there"),
        ("two.md#no-heading", "is no heading there"),
        ("two.md#its-part-2", "is no heading there"),
        ("#gone", "is no heading there"),
        ("../../README.md", "leads out of the manual"),
        ("../developer/why.md", "leads out of the manual"),
        ("../../../outside.md", "does not exist"),
    ],
)
@pytest.mark.parametrize("form", ["[a]({})", "![a]({})", '[a]({} "title")', "[a]: {}", '<img src="{}">'])
def test_broken_link_is_found(tmp_path: Path, form: str, link: str, problem: str) -> None:
    tree = {
        "docs/manual/one.md": f"# Here\n\n{form.format(link)}\n",
        "docs/manual/two.md": PAGE,
        "docs/developer/why.md": "# Why\n",
        "README.md": "# All\n",
    }
    assert link_offences(grow(tmp_path, tree)) == [f"docs/manual/one.md:3: {link} {problem}"]


def test_other_pages_may_lead_anywhere_in_the_tree(tmp_path: Path) -> None:
    tree = {
        "README.md": "[a](docs/decisions/why.md) [b](native)",
        "docs/decisions/why.md": "[a](../../README.md)",
        "native/README.md": "Rooms.",
    }
    assert link_offences(grow(tmp_path, tree)) == []
