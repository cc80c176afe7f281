# SPDX-License-Identifier: GPL-3.0-or-later
"""What Sinew calls a method: by the task that it is for, or as the literature does."""

from collections.abc import Callable, Iterable, Iterator
from enum import Enum
from types import SimpleNamespace

from .methods import Control, Method


class Names(Enum):
    """Where the names of methods come from."""

    TASKS = "Tasks"
    LITERATURE = "Literature"


_choice = SimpleNamespace(names=Names.TASKS)


def choose(names: Names) -> None:
    """Show methods by these names from now on, wherever Sinew shows one."""
    _choice.names = names


def chosen() -> Names:
    """The names in use."""
    return _choice.names


def label_of(method: Method) -> str:
    """The name that panels, menus, messages and reports show."""
    return method.label if chosen() is Names.TASKS else method.known_as


def names_of(methods: Iterable[Method]) -> str:
    """Methods to choose from, as a message names them."""
    return " or ".join(map(label_of, methods))


def known_as(method: Method) -> str:
    """The other name of the method."""
    return method.known_as if chosen() is Names.TASKS else method.label


def tooltip_of(method: Method) -> str:
    """What it does, and on a line of its own its other name where that differs."""
    other = known_as(method)
    return method.summary if other == label_of(method) else f"{method.summary}.\nKnown as {other}"


def fails_of(method: Method) -> str:
    """Where it fails, after a word that says so."""
    return f"Fails: {method.fails[:1].lower()}{method.fails[1:]}"


def items_of(methods: tuple[Method, ...], headed: bool = False) -> Callable[..., tuple[tuple, ...]]:
    """What Blender asks for the items of a list of methods; ``headed`` puts what artists move above its own.

    It keeps what it has answered, since Blender does not copy the texts.
    """
    answers: dict[Names, tuple[tuple, ...]] = {}

    def items(_owner: object = None, _context: object = None) -> tuple[tuple, ...]:
        if chosen() not in answers:
            answers[chosen()] = tuple(_listed(methods, headed))
        return answers[chosen()]

    return items


def _listed(methods: tuple[Method, ...], headed: bool) -> Iterator[tuple]:
    for control in Control:
        rows = [method for method in methods if method.control is control]
        if headed and rows:
            yield "", control.value, ""
        for method in rows:
            yield method.id, label_of(method), tooltip_of(method), "NONE", method.number
