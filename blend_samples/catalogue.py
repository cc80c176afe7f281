# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds a sample by its name."""

import importlib
from types import ModuleType

from .lineup import Lineup
from .lineups import LINEUPS


def find(name: str) -> Lineup | ModuleType:
    """A row of a table, or a script; both have ``make() -> Scene``."""
    return LINEUPS.get(name) or importlib.import_module(f"blend_samples.scenes.{name}")
