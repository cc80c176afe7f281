# SPDX-License-Identifier: GPL-3.0-or-later
import os
import re
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest
from workshop import blender_matrix, blenders, environments, layers, run_tests, windows_tests
from workshop.environments import REQUIREMENTS, blender, included
from workshop.layers import LAYERS, QUICK, Layer, blender_layer
from workshop.places import PYTHON311, ROOT
from workshop.results import Outcome
from workshop.shell import run, say

RELEASES = (*blender_matrix.BETWEEN, "5.2.3")


@pytest.mark.parametrize("version", RELEASES)
def test_each_release_is_pinned_with_all_that_its_tests_import(version: str) -> None:
    files = included([REQUIREMENTS / f"bpy-{version}.txt"])
    pins = dict(line.split("==") for file in files for line in file.read_text().splitlines() if "==" in line)
    assert pins["bpy"] == version
    assert {"numpy", "pytest", "pytest-timeout", "hypothesis"} <= set(pins)
    if version < "4.5":  # NumPy 2 makes these print tracebacks
        assert pins["numpy"].startswith("1.")
    assert version >= "5.1" or blender(version).interpreter == PYTHON311


def test_release_without_its_python_has_no_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(environments, "python313", lambda: None)
    assert blender("5.2.3") is None
    assert environments.newest_blender().name == "bpy-5.0.1"


def test_change_of_an_included_file_renews_the_environment(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("-r b.txt\nx==1\n")
    (tmp_path / "b.txt").write_text("-r c.txt\n")
    (tmp_path / "c.txt").write_text("y==1\n")
    assert {file.name for file in included([tmp_path / "a.txt"])} == {"a.txt", "b.txt", "c.txt"}


def test_no_two_layers_share_a_user_folder() -> None:
    names = [layer.name for layer in LAYERS]
    assert len(set(names)) == len(names)
    releases = {version.rpartition(".")[0] for version in RELEASES}
    assert {blender_layer(version).name for version in RELEASES} == {f"blender-{each}" for each in releases}


def test_layers_are_named_whole_or_by_their_first_word() -> None:
    every = [layer.name for layer in run_tests.chosen([])]
    windows = [layer.name for layer in run_tests.chosen(["windows"])]
    kinds = ["native", "bindings", "blender", "bindings-3.13", "processors", "blender-5", "updates"]
    assert windows == [f"windows-{kind}" for kind in kinds]
    assert every == [layer.name for layer in LAYERS if layer.name not in {*windows, "neon", "sanitizers"}]
    assert [layer.name for layer in run_tests.chosen(["windows-native", "gui"])] == ["windows-native", "gui"]


def test_whole_takes_all_tests_of_each_core() -> None:
    core, whole = (run_tests.chosen(["windows"], each) for each in (False, True))
    assert [layer.name for layer in core] == [layer.name for layer in whole]
    assert [a is b for a, b in zip(core, whole, strict=True)] == [True, False, False, False, True, True, True]


def test_what_is_not_quick_is_named_with_the_command_for_it() -> None:
    said = run_tests.left_out()
    quick = [layer.name for layer in QUICK]
    assert set(quick) < {layer.name for layer in run_tests.chosen([])}
    assert all(layer.name in said for layer in run_tests.chosen([]) if layer.name not in quick)
    assert all(layer.without in said for layer in QUICK)
    assert "tests/run --all" in said
    assert all(layer.name in said for layer in LAYERS if layer.only_by_name)


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[Layer]]:
    """``started("lint")``: the layers that `tests/run lint` runs. None of them runs."""

    def layers_of(*words: str) -> list[Layer]:
        seen: list[Layer] = []
        monkeypatch.setattr(run_tests, "run_layers", lambda layers, _remark="": seen.extend(layers))
        monkeypatch.setattr("sys.argv", ["tests/run", *words])
        for name in ("PYTEST_ADDOPTS", "GTEST_FILTER"):
            monkeypatch.setenv(name, "")  # so that what is set now is taken back
        with pytest.raises(SystemExit) as ended:
            run_tests.main()
        assert ended.value.code in (0, 2)
        return seen

    return layers_of


def test_without_a_word_a_quick_selection_runs(started: Callable[..., list[Layer]]) -> None:
    assert started() == list(QUICK)
    assert started("--all") == run_tests.chosen([])
    assert started("blender-3.4") == [layer for layer in LAYERS if layer.name == "blender-3.4"]
    assert started("windows", "--whole") == run_tests.chosen(["windows"], whole=True)
    assert started("--all", "lint") == started("-k", "lattice") == []  # refused


def test_one_test_by_its_name(started: Callable[..., list[Layer]]) -> None:
    assert [layer.name for layer in started("blender-5", "-k", "lattice and not cage")] == ["blender-5"]
    assert shlex.split(os.environ["PYTEST_ADDOPTS"]) == ["-k", "lattice and not cage"]
    started("native", "-k", "Arap")
    assert os.environ["GTEST_FILTER"] == "*Arap*"


def test_what_is_chosen_of_the_tests_is_there() -> None:
    chosen = layers.CORE_TESTS + layers.QUICK_BLENDER + windows_tests.CORE_TESTS
    in_blender = tuple(word for word in chosen if word.endswith(".py"))
    cores = {"blender": in_blender, "bindings": windows_tests.CORE_BINDINGS}
    for folder, names in cores.items():
        assert [name for name in names if not any((ROOT / "tests" / folder).rglob(name))] == []


def test_a_failed_layer_does_not_stop_the_next(capsys: pytest.CaptureFixture[str]) -> None:
    def broken(_timeout: float) -> Outcome:
        raise SystemExit("no such package\nof all that there are")

    chain = [Layer("broken", 1, broken), Layer("fine", 1, lambda _timeout: Outcome(passed=3))]
    assert run_tests.run_layers(chain) == 1
    said = capsys.readouterr().out
    assert said.count("no such package") == 2  # where the layer stopped, and in the table
    assert "no such package\nof all that there are" in said
    assert said.endswith("3 passed, 1 failed\n")


def test_layers_of_one_process_run_beside_each_other_and_print_one_after_the_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each waits for a file that the other writes, so neither would end if they ran one after the other."""
    monkeypatch.setattr(run_tests, "RESULTS", tmp_path)
    monkeypatch.setattr(run_tests, "jobs", lambda: 2)

    def meets(own: str, other: str) -> Outcome:
        script = f"echo first of {own}; touch {own}; until [ -e {other} ]; do sleep .01; done"
        run(["bash", "-c", script], cwd=tmp_path)
        say(f"last of {own}")
        return Outcome(passed=1)

    pair = [
        Layer(own, 1, lambda _timeout, own=own, other=other: meets(own, other), one_process=True)
        for own, other in (("left", "right"), ("right", "left"))
    ]
    assert run_tests.run_layers([*pair, Layer("broken", 1, lambda _timeout: Outcome(failed=1))]) == 1
    said = capsys.readouterr().out
    for name in ("left", "right"):
        assert re.search(f"==== {name} =+\nfirst of {name}\nlast of {name}\n", said)
    assert said.endswith("2 passed, 1 failed\n")


def test_each_release_plays_random_sequences_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("SINEW_RANDOM_SEQUENCES", raising=False)
    names = [layer.name for layer in LAYERS if layer.name.startswith("blender-")]
    assert len({blenders.conditions(name)["SINEW_RANDOM_SEED"] for name in names}) == len(names)
    assert sum(int(blenders.conditions(name)["SINEW_RANDOM_SEQUENCES"]) for name in names) == 150
    monkeypatch.setenv("SINEW_RANDOM_SEQUENCES", "3")
    assert blenders.conditions("blender-5")["SINEW_RANDOM_SEQUENCES"] == "3"


def test_wheels_for_programs_are_built_where_their_python_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(environments, "python", lambda minor: Path("/x") if minor != 14 else None)
    assert list(environments.builders()) == [11, 13]
    assert list(environments.builders(for_programs=True)) == [10, 11, 12, 13]
