# SPDX-License-Identifier: GPL-3.0-or-later
from contextlib import nullcontext
from pathlib import Path

import pytest
from workshop import cross_libraries, environments, shell, windows_wheels, wine
from workshop.layers import Layer
from workshop.results import Outcome
from workshop.run_tests import run_layer


@pytest.mark.parametrize(
    ("imported", "complaint"),
    [
        ({"python311.dll", "kernel32.dll", "api-ms-win-crt-heap-l1-1-0.dll"}, None),
        ({"python311.dll", "libc++.dll"}, "libc"),
        ({"python313.dll"}, "python313.dll"),
    ],
)
def test_a_module_that_not_every_windows_could_run_is_refused(
    imported: set[str], complaint: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(windows_wheels, "imported_libraries", lambda module: imported)
    with pytest.raises(SystemExit, match=complaint) if complaint else nullcontext():
        windows_wheels.check_module(Path("x.pyd"), 11)


@pytest.mark.parametrize(
    ("failing", "said"),
    [
        ("apt_install", "Debian's packages wine, wine64 are not all here"),
        ("wineboot", "Wine is installed, but could not make its drive C"),
        ("pip", "pip could not get what tools/requirements/windows-3.11.txt names"),
    ],
)
def test_a_machine_that_cannot_run_windows_programs_says_what_it_lacks(
    failing: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No Wine, a Wine that does not start, no network: each stands in the table of the layers."""

    def run(command: list[str], **_options) -> int:
        return int(any(Path(word).name == failing for word in command))

    def tests(_timeout: float) -> Outcome:
        wine.set_up()
        wine.python(11)
        return Outcome(passed=1)

    (tmp_path / "embedded").mkdir()
    (tmp_path / "embedded" / "python311._pth").touch()
    for module in (shell, wine, cross_libraries):
        monkeypatch.setattr(module, "BUILD", tmp_path / "build")
    monkeypatch.setattr(shell, "run", run)
    monkeypatch.setattr(wine, "PREFIX", tmp_path / "build" / "wine")
    monkeypatch.setattr(wine, "windows_python", lambda minor: tmp_path / "embedded")
    monkeypatch.setattr(environments.Environment, "make", lambda environment: environment)
    found, _seconds = run_layer(Layer("windows-bindings", 1, tests))
    assert found.failed == 1
    assert said in found.note
