# SPDX-License-Identifier: GPL-3.0-or-later
"""Engines bake a shot to the bits of one process, also where their parts are killed."""

import json
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from sinew_farm import atom

HERE, BLENDER = Path(__file__).parent, os.environ["SINEW_ATOM"]  # Python with Blender, and command.py
FARM, OPENJD = [sys.executable, "-m", "sinew_farm"], Path(sys.executable).with_name("openjd")
WORDS = ["--frames", "1-240", "--objects", "Body", "--format", "pc2", "--out"]
READ = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
OLDER = ["--background", "--python", "/sinew/farm/command.py", "--", "bake"]
ADDRESS = f"tcp://127.0.0.1:{20_000 + os.getpid() % 10_000}"
# What is done to the worker that bakes, to the command, or to all processes; and what is printed then.
DEEDS = {
    "a worker is killed": (lambda worker, command, every: worker.kill(), ""),
    "a network is cut": (lambda worker, command, every: worker.suspend(), ""),
    "two disks are full": (lambda worker, command, every: [full(each) for each in every[1:3]], '"failed"'),
    "Blender crashes": (lambda worker, *_: worker.children()[0].send_signal(signal.SIGSEGV), "status -11"),
    "the scheduler is killed": (lambda worker, command, every: restart(every), "scheduler lost"),
    "the command is killed": (lambda worker, command, every: command.kill(), ""),
}


def said(*words: object, code: int = 0) -> str:
    ended = subprocess.run(list(map(str, words)), **READ)
    assert ended.returncode == code, ended.stdout
    return ended.stdout


@pytest.fixture(scope="module")
def shot(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A shot, and beside it what one process bakes of it."""
    file = tmp_path_factory.mktemp("shot") / "shot.blend"
    said(BLENDER.split()[0], HERE / "make_shot.py", file, 40)
    said(*BLENDER.split(), "bake", file, *WORDS, file.parent)
    said(*BLENDER.split(), "join", file.parent, *WORDS, file.parent)
    return file


def same(shot: Path, out: Path) -> bool:
    return (out / "Body.pc2").read_bytes() == shot.with_name("Body.pc2").read_bytes()


def full(process: psutil.Popen) -> None:
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (10_000, 10_000))


def restart(processes: list[psutil.Popen]) -> None:
    for process in processes:
        process.kill()
    env = os.environ | {"DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": "10s"}
    starts = [["scheduler", "--host", ADDRESS], *[["worker", ADDRESS, "--nthreads", "1", "--no-nanny"]] * 4]
    commands = [[sys.executable, "-m", "dask", *words, "--no-dashboard"] for words in starts]
    processes[:] = [psutil.Popen(words, env=env, stderr=subprocess.DEVNULL) for words in commands]


@pytest.fixture
def processes() -> Iterator[list[psutil.Popen]]:
    """A scheduler and four workers."""
    restart(made := [])
    yield made
    for process in made:
        process.kill()


@pytest.mark.parametrize("deed", DEEDS)
def test_no_frame_is_lost_and_none_that_is_there_is_baked_again(
    shot, tmp_path: Path, processes, deed
) -> None:
    do, says = DEEDS[deed]
    words = [*FARM, "dask", shot, "--chunk", "30", "--scheduler", ADDRESS, "--blender", BLENDER, "--json"]
    with subprocess.Popen([*words, *WORDS, tmp_path], **READ) as command:
        for line in command.stdout:
            if do and '"frame"' in line:
                do(next(each for each in processes[1:] if each.children()), command, processes)
                do = None
            says = "" if says in line else says
    there = {file: file.stat().st_mtime_ns for file in tmp_path.glob("chunks/Body*.pc2")}
    if "command" in deed:
        assert len(there) < 8
        said(*words, *WORDS, tmp_path)
    assert not says
    assert same(shot, tmp_path)
    assert all(file.stat().st_mtime_ns == time for file, time in there.items())
    assert len(list(tmp_path.glob("chunks/*"))) == 16  # with their manifests


def test_a_refusal_ends_all_with_its_status(shot: Path, tmp_path: Path) -> None:
    words = ["--workers", 2, "--blender", BLENDER, *WORDS, tmp_path, "--objects", "Nobody"]
    assert said(*FARM, "dask", shot, *words, code=3).count("failed on") < 4
    assert not list(tmp_path.glob("**/*.*"))


def test_the_job_of_flamenco_bakes_chunks_and_joins_after_all_of_them(shot: Path, tmp_path: Path) -> None:
    settings = {
        "frames": "1-240",
        "objects": "Body",
        "format": "pc2",
        "out": str(tmp_path),
        "chunk_size": 100,
    }
    settings |= {"blendfile": str(shot), "threads": 1, "memory": 0, "script": "command.py"}
    script = said(*FARM, "flamenco") + (HERE / "flamenco.js").read_text()
    *bakes, join = json.loads(said("node", "-e", script, json.dumps(settings)))
    assert join["after"] == ["bake-1-100", "bake-101-200", "bake-201-240"] == [task["name"] for task in bakes]
    for task in (*bakes, join):
        assert task["words"][:4] == ["--background", "--python", "command.py", "--"]
        said(*BLENDER.split(), *task["words"][4:])
    assert same(shot, tmp_path)


def test_the_template_of_openjd_is_valid_and_bakes(shot: Path, tmp_path: Path) -> None:
    (tmp_path / "sinew.yaml").write_text(said(*FARM, "openjd"))
    words = [tmp_path / "sinew.yaml", "--extensions", "TASK_CHUNKING"]
    said(OPENJD, "check", *words)
    given = {"Shot": shot, "Out": tmp_path, "Objects": "Body", "Chunk": 100, "Blender": BLENDER}
    words += [word for name, value in given.items() for word in ("-p", f"{name}={value}")]
    assert said(OPENJD, "run", *words).count("openjd_progress: 100.0") == 3
    assert same(shot, tmp_path)
    assert "openjd_fail: " in said(OPENJD, "run", *words, "-p", "Objects=Nobody", code=1)


@pytest.mark.parametrize(("release", "way"), [("4.2.0", ["--command", "sinew_bake"]), ("3.4.1", OLDER)])
def test_a_blender_is_started_in_the_way_of_its_release(tmp_path: Path, release: str, way: list[str]) -> None:
    blender = tmp_path / "blender"
    blender.write_text(f"#!/bin/sh\necho Blender {release}\necho sinew is in /sinew/__init__.py\nexit 1\n")
    blender.chmod(0o755)
    assert atom.command(f"{blender} -y", "bake", ["x"]) == [str(blender), "-y", *way, "x"]
    assert atom.run(str(blender), "bake", ["x"]).code == atom.REFUSED  # as it tells nothing of Sinew
