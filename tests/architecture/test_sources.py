# SPDX-License-Identifier: GPL-3.0-or-later
from pathlib import Path

import pytest

from . import sources
from .tree import ROOT, grow


def test_all_versions_agree() -> None:
    stated = sources.versions(ROOT)
    assert len(set(stated.values())) == 1, stated


@pytest.mark.parametrize("path", ["native/core/a.h", "addon/a.py", "tools/go", "CMakeLists.txt", ".ci/run"])
def test_missing_licence_is_found(tmp_path: Path, path: str) -> None:
    grow(tmp_path, {path: "#!/bin/sh\n\n\n\n# " + sources.LICENCE})
    assert sources.licence_offences(tmp_path) == [f"{path}:1: does not name its licence"]
    grow(tmp_path, {path: f"#!/bin/sh\n# {sources.LICENCE}\n"})
    assert sources.licence_offences(tmp_path) == []


def test_long_file_is_found(tmp_path: Path) -> None:
    grow(
        tmp_path, {"native/core/a.h": "\n" * sources.LONGEST, "native/core/b.h": "\n" * (sources.LONGEST + 1)}
    )
    assert sources.size_offences(tmp_path) == [f"native/core/b.h: {sources.LONGEST + 1} lines"]


def test_former_names_are_found(tmp_path: Path) -> None:
    pages = {
        "addon/a.py": 'text="Add Cage"\n',
        "docs/manual/a.md": "**Set Rest Cage**\n",
        "CHANGELOG.md": "Add Cage\n",
    }
    found = sources.former_name_offences(grow(tmp_path, pages))
    assert [offence.partition(":")[0] for offence in found] == ["addon/a.py", "docs/manual/a.md"]
    pages = {"addon/a.py": "", "docs/manual/a.md": "**New Rest**\n"}
    assert sources.former_name_offences(grow(tmp_path, pages)) == []


def test_only_the_core_asks_for_a_system(tmp_path: Path) -> None:
    asked = dict.fromkeys(["native/core/a.cpp", "native/mesh/a.cpp"], "int a;\n#ifdef __linux__\n#endif\n")
    (offence,) = sources.system_offences(grow(tmp_path, asked))
    assert offence.startswith("native/mesh/a.cpp:2:")


def test_only_colours_may_differ_in_the_last_bit(tmp_path: Path) -> None:
    places = ("addon/core/a.py", "addon/ui/a.py", "addon/core/geometry/distortion.py")
    (offence,) = sources.last_bit_offences(grow(tmp_path, dict.fromkeys(places, "y = np.arctan2(1, x)\n")))
    assert offence.startswith("addon/core/a.py:1:")


def test_two_classes_of_one_name_are_found(tmp_path: Path) -> None:
    of_all = "namespace sinew {{\n{}class Factor\n{{\n}};\n{}}} // namespace sinew\n"
    alone = of_all.format("namespace {\n", "} // namespace\n")
    tree = {"native/a.h": of_all.format("", ""), "native/b.cpp": alone, "native/c.h": "class Factor;\n"}
    assert sources.class_name_offences(grow(tmp_path, tree)) == []
    (offence,) = sources.class_name_offences(grow(tmp_path, {"native/d.h": of_all.format("", "")}))
    assert offence == "native/d.h:2: sinew::Factor is defined at native/a.h:2, too"


@pytest.mark.parametrize(
    "line",
    [
        "open('/wor|k/main/a.obj')",
        "/roo|t/.pyenv",
        "/hom|e/ada/sinew",
        "pyp|i.org/simple",
        "# TOD|O: later",
        "raise NotImplemented|Error",
        "except Exceptio|n as error:",
        "exc|ept:",
        "catch (|...)",
        "*reinterpret_cas|t<const Pair*>(numbers)",
    ],
)
def test_word_that_does_not_belong_here_is_found(tmp_path: Path, line: str) -> None:
    whole = line.replace("|", "")  # this file may not hold it either
    (offence,) = sources.word_offences(grow(tmp_path, {"addon/a.py": f"x = 1\n{whole}\n"}))
    assert offence.startswith("addon/a.py:2:")
    assert whole in offence


@pytest.mark.parametrize(
    "line", ["except ValueError:", "work/main", "a.root/b", "the home/of", "catch (Error& e)"]
)
def test_innocent_word_is_left_alone(tmp_path: Path, line: str) -> None:
    assert sources.word_offences(grow(tmp_path, {"addon/a.py": line})) == []


@pytest.mark.parametrize("text", ["One room.", "Reads a.h. And more.", ""])
def test_door_plate_is_one_sentence(tmp_path: Path, text: str) -> None:
    plates = {"native/core/README.md": text, "native/README.md": "All rooms.", "addon/README.md": "Plate."}
    found = [] if text == "One room." else ["native/core/README.md: must be one sentence"]
    assert sources.door_plate_offences(grow(tmp_path, plates)) == found


def test_disagreeing_version_is_seen(tmp_path: Path) -> None:
    tree = {
        "CMakeLists.txt": "project(sinew VERSION 1.2.3 LANGUAGES CXX)",
        "addon/blender_manifest.toml": 'version = "1.2.3"',
        "addon/__init__.py": 'bl_info = {"version": (1, 2, 3)}',
        "addon/ids.py": 'VERSION = "1.2.4"',
        "CITATION.cff": "version: 1.2.3",
        "CHANGELOG.md": "## [Unreleased]\n\n## [1.2.3] - 2030-01-01\n",
    }
    stated = sources.versions(grow(tmp_path, tree))
    assert {place for place, version in stated.items() if version != "1.2.3"} == {"addon/ids.py"}
