# SPDX-License-Identifier: GPL-3.0-or-later
"""The programs in examples/ work on an installed Sinew alone, and give the same answer."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from bindings.meshes import closed_bar
from workshop.dev import build_tree
from workshop.places import DEV_MODULE, NATIVE_TREE, ROOT, version
from workshop.shell import must

SIN, COS = 0.75**0.5, 0.5  # of 60 degrees


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[str | Path]]:
    """The commands. The one in C++ is compiled elsewhere, with instructions that the library lacks; beside it
    all headers, with what the page shows."""
    folder = tmp_path_factory.mktemp("installed")
    build_tree("dev", "sinew_native")
    must(["cmake", "--install", NATIVE_TREE, "--prefix", folder / "prefix"], quiet=True)
    shutil.copytree(ROOT / "examples", folder / "examples")
    (page,) = re.findall("```cpp\n(.*?)```", (ROOT / "docs/developer/cpp.md").read_text(), re.DOTALL)
    headers = [f'#include "{header}"\n' for header in (folder / "prefix").rglob("*.h")]
    (folder / "examples" / "page.cpp").write_text("".join([*headers, page]))
    with (folder / "examples" / "CMakeLists.txt").open("a") as project:
        project.write("add_library(page OBJECT page.cpp)\ntarget_link_libraries(page PRIVATE sinew::sinew)\n")
    options = [f"-DCMAKE_PREFIX_PATH={folder / 'prefix'}", "-DCMAKE_CXX_FLAGS=-march=native -O1"]
    must(["cmake", "-S", folder / "examples", "-B", folder / "build", *options], quiet=True)
    must(["cmake", "--build", folder / "build", "-j", "2"], quiet=True)
    return {"C++": [folder / "build" / "bend"], "Python": [sys.executable, folder / "examples" / "bend.py"]}


def run(command: list[str | Path], *files: Path) -> subprocess.CompletedProcess[str]:
    words = list(map(str, (*command, *files)))
    return subprocess.run(words, env={"PYTHONPATH": str(DEV_MODULE)}, capture_output=True, text=True)


def test_both_programs_bend_a_bar_alike_and_meet_their_handles(programs, tmp_path: Path) -> None:
    points, (counts, corners) = closed_bar(20, 4)
    points = points[:, [1, 2, 0]]  # along the z axis
    lines = ["# a bar", *("v {} {} {}".format(*point) for point in points), "vn 0 0 1"]
    for face in np.split(corners + 1, np.cumsum(counts)[:-1]):
        lines.append("f " + " ".join(f"{corner}//1" for corner in face))
    (tmp_path / "bar.obj").write_text("\n".join(lines))
    found = {}
    for name, command in programs.items():
        ended = run(command, tmp_path / "bar.obj", tmp_path / f"{name}.obj")
        assert (ended.returncode, ended.stdout, ended.stderr) == (0, "", ""), name
        words = [line.split() for line in (tmp_path / f"{name}.obj").read_text().splitlines()]
        found[name] = np.array([line[1:] for line in words if line[0] == "v"], float)
        faces = [" ".join(line) for line in words if line[0] == "f"]
        assert faces == [line.replace("//1", "") for line in lines if line[0] == "f"]

    bent, height, centre = found["C++"], points[:, 2] / 20, points.mean(axis=0)
    np.testing.assert_allclose(bent[height < 0.1], points[height < 0.1], atol=1e-12)
    posed = (points - centre) @ np.array([(COS, 0, -SIN), (0, 1, 0), (SIN, 0, COS)]) + centre
    np.testing.assert_allclose(bent[height > 0.9], posed[height > 0.9], atol=1e-12)
    # The poses differ by their last bits, since the programs compute them in another order.
    np.testing.assert_allclose(found["Python"], bent, atol=1e-9)


def test_what_the_programs_cannot_read_is_said_in_a_sentence(programs, tmp_path: Path) -> None:
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    texts = {"hole": f"{corners}f 1 2 4\n", "word": f"{corners}f a b c\n", "empty": "", "short": "v 0 0\n"}
    for name, text in texts.items():
        (tmp_path / f"{name}.obj").write_text(text)
    saying = {"none": "none.obj", "hole": "faces 0", "empty": "no vertices", "word": "", "short": ""}
    for command in programs.values():
        assert "usage" in run(command).stderr
        for name, says in saying.items():
            ended = run(command, tmp_path / f"{name}.obj", tmp_path / "o")
            assert (ended.returncode, len(ended.stderr.splitlines())) == (1, 1), ended.stderr
            assert says in ended.stderr


def test_a_program_that_was_written_for_an_earlier_version_is_refused(programs, tmp_path: Path) -> None:
    """Before version 1 the second number tells that something does not fit any more."""
    words = "cmake_minimum_required(VERSION 3.22)\nproject(a NONE)\nfind_package(sinew 0.0.1 REQUIRED)\n"
    (tmp_path / "CMakeLists.txt").write_text(words)
    prefix = programs["C++"][0].parents[1] / "prefix"
    command = ["cmake", "-S", tmp_path, "-B", tmp_path / "build", f"-DCMAKE_PREFIX_PATH={prefix}"]
    refused = subprocess.run(command, capture_output=True, text=True)
    assert refused.returncode == 1
    assert f"version: {version()}" in refused.stderr
