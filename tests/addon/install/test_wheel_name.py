# SPDX-License-Identifier: GPL-3.0-or-later
"""The name of the wheel that the preferences ask for where the native module is missing."""

import fnmatch
import platform
import sys

import pytest

WHEELS = {
    ("Linux", "x86_64"): "manylinux_2_34_x86_64",
    ("Windows", "AMD64"): "win_amd64",
    ("Darwin", "arm64"): "macosx_11_0_arm64",
}


@pytest.mark.parametrize(("system", "machine"), WHEELS)
def test_the_name_fits_the_wheel_of_this_system_alone(
    system: str, machine: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    from sinew.backend import loader

    monkeypatch.setattr(platform, "system", lambda: system)
    monkeypatch.setattr(platform, "machine", lambda: machine)
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    names = [f"sinew_native-{loader.VERSION}-{python}-{python}-{tag}.whl" for tag in WHEELS.values()]
    fits = [name for name in names if fnmatch.fnmatchcase(name, loader.wheel_name())]
    assert fits == [f"sinew_native-{loader.VERSION}-{python}-{python}-{WHEELS[system, machine]}.whl"]
