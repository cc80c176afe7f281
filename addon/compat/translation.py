# SPDX-License-Identifier: GPL-3.0-or-later
"""Sentences in the language of Blender's interface.

Blender itself translates labels, tooltips and what a layout draws as it is written, once a table is
registered. It does not do so for reports, for why a button is grey, for texts of the status bar, and for
sentences that hold names or numbers. Those go through ``told``.
"""

import re
from functools import cache

import bpy

# A table per language, by its locale in Blender, such as "de_DE": what Sinew says, and how it reads there.
# "..." stands for what differs, as on the pages of the manual; the other side has {0}, {1} for it.
LANGUAGES: dict[str, dict[str, str]] = {}
GAP = "..."
_CLAUSES = re.compile(r"(; |, | - |\. )")


def told(text: str) -> str:
    """A sentence in the language of the interface; as it is where no table has it, or only its clauses."""
    table = LANGUAGES.get(_locale(), {})
    if not table:
        return text
    whole = _translated(text, table)
    if whole is not None:
        return whole
    parts = _CLAUSES.split(text)
    return text if len(parts) == 1 else "".join(_translated(part, table) or part for part in parts)


def register() -> None:
    """Give Blender the sentences that it translates by itself."""
    plain = {
        locale: {("*", said): reads for said, reads in table.items() if GAP not in said}
        for locale, table in LANGUAGES.items()
    }
    if plain:
        bpy.app.translations.register(__name__, plain)


def unregister() -> None:
    """Take them back."""
    if LANGUAGES:
        bpy.app.translations.unregister(__name__)
    _pattern.cache_clear()


def _locale() -> str:
    """The language of the interface; none where Blender is told not to translate messages."""
    view = bpy.context.preferences.view
    return bpy.app.translations.locale or view.language if view.use_translate_interface else ""


def _translated(text: str, table: dict[str, str]) -> str | None:
    if text in table:
        return table[text]
    for said, reads in table.items():
        found = _pattern(said).fullmatch(text) if GAP in said else None
        if found:
            return reads.format(*found.groups())
    return None


@cache
def _pattern(said: str) -> re.Pattern[str]:
    return re.compile("(.+?)".join(map(re.escape, said.split(GAP))))
