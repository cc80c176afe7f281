# SPDX-License-Identifier: GPL-3.0-or-later
"""For every layer."""

from collections import Counter
from collections.abc import Callable
from types import ModuleType

import pytest

BINDS = ("SurfaceMesh", "diagnose", "set_handles", "rebind")


@pytest.fixture
def count_native(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Counter]:
    """``count_native(module, *names)``: how often the native module is asked for these from now on."""

    def count(native: ModuleType, *names: str) -> Counter:
        found: Counter = Counter()

        def counted(name: str, inner: Callable) -> Callable:
            def call(*arguments, **keywords):
                found[name] += 1
                return inner(*arguments, **keywords)

            return call

        # some have verbs of their own
        methods = [*native.SurfaceMethod.__subclasses__(), *native.SpaceMethod.__subclasses__()]
        for owner in (native, native.SurfaceMesh, native.SurfaceMethod, native.SpaceMethod, *methods):
            for name in names or BINDS:
                if name in vars(owner):
                    monkeypatch.setattr(owner, name, counted(name, getattr(owner, name)))
        return found

    return count
