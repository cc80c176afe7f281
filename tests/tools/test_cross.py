# SPDX-License-Identifier: GPL-3.0-or-later
"""What the wheels for all systems are built from."""

import re
from pathlib import Path

import pytest
from workshop import cross_libraries, linux_wheels, macos_wheels, neon_tests, windows_libraries
from workshop.places import ROOT

SOURCES = cross_libraries.LIBRARIES / "sources.txt"


@pytest.mark.parametrize("file", [SOURCES, windows_libraries.PYTHONS])
def test_every_source_is_pinned_by_its_digest(file: Path) -> None:
    rows = cross_libraries.pinned(file)
    assert len(rows) >= 2
    assert all(re.fullmatch("[0-9a-f]{64}", row.digest) for row in rows)


def test_another_file_than_the_pinned_one_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cross_libraries, "SOURCES", tmp_path)
    source = cross_libraries.pinned(SOURCES)[0]
    with pytest.raises(SystemExit, match="no longer brings"):
        cross_libraries.check(source)
    source.path.write_bytes(b"other")
    with pytest.raises(SystemExit, match=source.digest):
        cross_libraries.check(source)


@pytest.mark.parametrize(
    "system",
    [linux_wheels.SYSTEM, windows_libraries.WINDOWS, macos_wheels.SYSTEM, neon_tests.SYSTEM],
    ids=lambda system: system.name,
)
def test_each_system_has_its_own_tree_and_its_toolchain(system: cross_libraries.System) -> None:
    assert (system.files / "toolchain.cmake").is_file()
    assert system.prefix.is_relative_to(cross_libraries.BUILD / system.name)
    assert f"-DCMAKE_PREFIX_PATH={system.prefix}" in system.configuration()


def test_the_tests_of_all_kernels_run_on_arm() -> None:
    tests = (ROOT / "tests" / "native").rglob("*.cpp")
    named = [path for path in tests if "kernels<" in path.read_text(encoding="utf-8")]
    assert len(named) >= 10
    assert [path for path in named if not re.search(neon_tests.KERNELS, path.as_posix())] == []


def test_what_is_compiled_for_arm_is_there() -> None:
    text = (neon_tests.SYSTEM.files / "CMakeLists.txt").read_text(encoding="utf-8")
    listed = re.search(r"set\(sources ([^)]+)\)", text)[1].split()
    assert [name for name in listed if not (ROOT / "native" / f"{name}.cpp").is_file()] == []
