# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's rooms that need no Blender, importable as ``sinew.core`` and ``sinew.backend``."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

ADDON = Path(__file__).parents[2] / "addon"


def _package() -> None:
    """``sinew`` without running its ``__init__``, which registers with Blender."""
    package = ModuleType("sinew")
    package.__path__ = [str(ADDON)]
    package.__spec__ = importlib.util.spec_from_loader("sinew", loader=None, is_package=True)
    sys.modules["sinew"] = package


if "sinew" not in sys.modules:
    _package()


@pytest.fixture
def backend() -> ModuleType:
    pytest.importorskip("sinew_native")
    from sinew import backend

    return backend
