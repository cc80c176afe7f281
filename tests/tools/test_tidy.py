# SPDX-License-Identifier: GPL-3.0-or-later
import json
from pathlib import Path

import pytest
from workshop import shell, tidy


@pytest.fixture
def sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout of one source with two headers, of which it includes one through the other."""
    for module in (shell, tidy):
        monkeypatch.setattr(module, "ROOT", tmp_path)
    monkeypatch.setattr(tidy, "SETTINGS", (tmp_path / ".clang-tidy",))
    native = tmp_path / "native"
    native.mkdir()
    (tmp_path / ".clang-tidy").write_text("Checks: '*'")
    (native / "a.cpp").write_text('#include "native/a.h"\n#include <vector>\n')
    (native / "a.h").write_text('#include "native/b.inl"\n')
    (native / "b.inl").write_text('#include "native/a.h"\n')
    (native / "c.h").write_text("")
    tidy.included.cache_clear()
    tidy.directly_included.cache_clear()
    return native


def test_includes_are_followed_to_their_end(sources: Path) -> None:
    assert {path.name for path in tidy.included(sources / "a.cpp")} == {"a.h", "b.inl"}


@pytest.mark.parametrize(
    ("changed", "again"), [("a.cpp", True), ("b.inl", True), ("c.h", False), ("../.clang-tidy", True)]
)
def test_source_is_read_again_when_what_it_depends_on_changed(sources: Path, changed: str, again: bool):
    before = tidy.digest(sources / "a.cpp", "g++ -c a.cpp")
    (sources / changed).write_text("// new\n" + (sources / changed).read_text())
    tidy.directly_included.cache_clear()
    tidy.included.cache_clear()
    assert (tidy.digest(sources / "a.cpp", "g++ -c a.cpp") != before) is again


def test_source_is_read_again_when_it_is_compiled_otherwise_but_not_elsewhere(sources: Path) -> None:
    root = sources.parent
    assert tidy.digest(sources / "a.cpp", "g++ -O3") != tidy.digest(sources / "a.cpp", "g++ -O2")
    assert tidy.digest(sources / "a.cpp", f"g++ -I{root}") == tidy.digest(sources / "a.cpp", "g++ -I")


def test_sources_that_are_compiled_as_one_are_read_as_one(sources: Path, monkeypatch: pytest.MonkeyPatch):
    tree = sources.parent / "tree"
    monkeypatch.setattr(tidy, "NATIVE_TREE", tree)
    read = [sources / "a.cpp", tree / "native" / "k_baseline.cpp", tree / "CMakeFiles" / "Unity" / "0.cxx"]
    others = [tree / "native" / "k_avx2.cpp", tree / "benchmarks" / "CMakeFiles" / "Unity" / "0.cxx"]
    tree.mkdir()
    entries = [{"file": str(file), "command": "g++"} for file in (*read, *others)]
    (tree / "compile_commands.json").write_text(json.dumps(entries))
    assert set(tidy.commands()) == set(read)
    together = sources / "Unity.cxx"
    together.write_text(f'#include "{sources / "a.cpp"}"\n')
    assert tidy.sources_in(together) == {together, sources / "a.cpp"}
    assert tidy.sources_in(sources / "a.cpp") == {sources / "a.cpp"}
