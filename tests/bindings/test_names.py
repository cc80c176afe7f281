# SPDX-License-Identifier: GPL-3.0-or-later
"""What scripts name keeps its name: classes, functions, members and arguments of the module."""

import inspect
from collections.abc import Iterator
from pathlib import Path

from .test_contract import PUBLIC, stated_parameters

NAMES = Path(__file__).parents[1] / "names" / "python.txt"


def named(path: str, thing: object) -> Iterator[str]:
    """A line for a thing, with its arguments in their order, and one for each of its public members."""
    if inspect.isclass(thing):
        made_by = stated_parameters(thing.__init__) if "__init__" in vars(thing) else []
        yield f"{path}({', '.join(made_by)})".removesuffix("(type(self))").removesuffix("()")
        for name, member in vars(thing).items():
            if not name.startswith("_"):
                yield from named(f"{path}.{name}", member)
    elif callable(thing):
        yield f"{path}({', '.join(stated_parameters(thing))})"
    else:
        yield path


def test_the_module_keeps_its_names() -> None:
    now = sorted(line for name, thing in PUBLIC.items() for line in named(name, thing))
    assert now == NAMES.read_text(encoding="utf-8").splitlines()
