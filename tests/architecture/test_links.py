# SPDX-License-Identifier: GPL-3.0-or-later
from pathlib import Path

import pytest

from .links import link_offences
from .tree import grow

PAGE = "# One & all\n\n## Its part\n\n## Its part\n\n```\n# no heading\n[a](gone.md)\n```\n`[a](gone.md)`\n"
TREE = {
    "docs/manual/two.md": PAGE,
    "docs/manual/images/a b.jpg": "",
    "docs/methods/three.md": "# Three",
    "docs/developer/why.md": "[a](../../README.md)",
    "README.md": "[a](docs/developer/why.md) [b](docs)",
}
GOOD = "two.md two.md#its-part two.md#its-part-1 two.md#one--all ../methods/three.md images/a%20b.jpg #here"
FAULTS = {
    "gone.md": "does not exist",
    "images/gone.jpg": "does not exist",
    "two.md#gone": "is no heading there",
    "two.md#no-heading": "is no heading there",
    "two.md#its-part-2": "is no heading there",
    "#gone": "is no heading there",
    "../../README.md": "leads out of the manual",
    "../developer/why.md": "leads out of the manual",
    "../../../outside.md": "does not exist",
}
FORMS = ("[a]({})", "![a]({})", '[a]({} "title")', "[a]: {}", '<img src="{}">')


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("link", [*FAULTS, *GOOD.split(), "https://example.org/gone.md#gone"])
def test_a_broken_link_is_found_and_a_good_one_left_alone(tmp_path: Path, form: str, link: str) -> None:
    grow(tmp_path, TREE | {"docs/manual/one.md": f"# Here\n\n{form.format(link)}\n"})
    found = [f"docs/manual/one.md:3: {link} {FAULTS[link]}"] if link in FAULTS else []
    assert link_offences(tmp_path) == found
