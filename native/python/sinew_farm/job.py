# SPDX-License-Identifier: GPL-3.0-or-later
"""The jobs that other engines run: a job type script of Flamenco, a template of Open Job Description."""

from pathlib import Path
from textwrap import indent

HERE = Path(__file__).parent


def flamenco() -> str:
    """The script for the folder ``scripts`` beside a Flamenco Manager."""
    return (HERE / "sinew_bake.js").read_text(encoding="utf-8")


def openjd() -> str:
    """The template (jobtemplate-2023-09), which carries ``atom.py`` to the machines."""
    atom = (HERE / "atom.py").read_text(encoding="utf-8")
    template = (HERE / "sinew_bake.yaml").read_text(encoding="utf-8")
    return template.replace("@ATOM@", indent(atom, " " * 12).strip())
