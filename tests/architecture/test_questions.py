# SPDX-License-Identifier: GPL-3.0-or-later
"""What a stranger asks first is answered within two links of the README."""

from pathlib import Path
from urllib.parse import unquote

import pytest

from .links import links
from .tree import ROOT

# A question, the file that answers it, and the words of the answer there.
QUESTIONS = (
    ("how is a method added?", "CONTRIBUTING.md", "## Add a method"),
    ("what runs when a control moves?", "docs/developer/architecture.md", "## The way of a pose"),
    ("where are differences between Blender versions?", "docs/developer/architecture.md", "addon/compat"),
    (
        "where are Green coordinates computed?",
        "native/methods/space/cage/closed_forms/cage_kernels.inl",
        "green",
    ),
    ("where is a factor used again?", "native/solvers/constrained_quadratic.h", "factor"),
    ("where is the local step of ARAP?", "native/local_global/arap/arap_problem.h", "local_step"),
    ("where is the text of an error?", "docs/developer/architecture.md", "the text of an error"),
    ("where is the test of a deleted cage?", "docs/developer/events.md", "the_control_deleted"),
)


def linked(page: Path) -> set[Path]:
    """The files of the tree that a page links."""
    found = links(page) if page.suffix == ".md" else ()
    return {(page.parent / unquote(link.partition("#")[0])).resolve() for _number, link in found}


@pytest.mark.parametrize(("question", "answer", "words"), QUESTIONS, ids=[row[0] for row in QUESTIONS])
def test_a_question_is_answered_within_two_links_of_the_readme(question: str, answer: str, words: str):
    near = linked(ROOT / "README.md")
    pages = near | {file for page in near for file in linked(page)}
    assert ROOT / answer in pages, question
    assert words.lower() in (ROOT / answer).read_text(encoding="utf-8").lower()
