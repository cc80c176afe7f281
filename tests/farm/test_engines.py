# SPDX-License-Identifier: GPL-3.0-or-later
"""Engines bake a shot to the bits of one process, also where their parts are killed."""

import json
import os
import resource
import shlex
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import psutil
import pytest

from sinew_farm import atom

BLENDER = os.environ[
    "SINEW_ATOM"
]  # the command line of a Python with Blender, and of the add-on's command.py
FARM = [sys.executable, "-m", "sinew_farm"]
WORDS = ("--frames", "1-240", "--objects", "Body", "--format", "pc2", "--out")
OPENJD, CHUNKS = Path(sys.executable).with_name("openjd"), ["--extensions", "TASK_CHUNKING"]
NODE = """
const made = (name) => ({ name, after: [],
    addCommand(command) { this.words = command.args; }, addDependency(task) { this.after.push(task.name); } });
const author = { Task: made, Command: (name, words) => words }, tasks = [];
compileJob({ settings: JSON.parse(process.argv[1]), addTask: (task) => tasks.push(task) });
console.log(JSON.stringify(tasks));"""


def said(*words: str | Path, code: int = 0) -> str:
    ended = subprocess.run(list(map(str, words)), stdout=subprocess.PIPE, text=True)
    assert ended.returncode == code, ended.stdout
    return ended.stdout


@pytest.fixture(scope="module")
def shot(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A shot, and beside it what one process bakes of it."""
    file, blender = tmp_path_factory.mktemp("shot") / "shot.blend", shlex.split(BLENDER)
    said(blender[0], Path(__file__).with_name("make_shot.py"), file, "40")
    said(*blender, "bake", file, *WORDS, file.parent)
    said(*blender, "join", file.parent, *WORDS, file.parent)
    return file


class Cluster:
    """A scheduler with four workers, each a process, and the command that bakes on them."""

    def __init__(self) -> None:
        with socket.create_server(("127.0.0.1", 0)) as found:
            self.address = f"tcp://127.0.0.1:{found.getsockname()[1]}"
        self.start()

    def start(self) -> None:
        worker = ["worker", self.address, "--nthreads", "1", "--no-nanny"]
        words = [["scheduler", "--host", self.address], *[worker] * 4]
        silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        env = os.environ | {"DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": "10s"}
        command = [sys.executable, "-m", "dask"]
        self.processes = [
            subprocess.Popen([*command, *each, "--no-dashboard"], env=env, **silent) for each in words
        ]

    def kill(self) -> None:
        for process in self.processes:
            process.kill()

    def bake(
        self, shot: Path, out: Path, deed: Callable[["Cluster"], None], *further: str
    ) -> tuple[int, str]:
        """The status and what was printed, after a deed once frames are baked."""
        words = ["dask", shot, "--chunk", "30", "--scheduler", self.address, "--blender", BLENDER, "--json"]
        command = [*FARM, *words, *WORDS, out, *further]
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        ) as self.command:
            printed = ""
            for line in self.command.stdout:
                if '"frame"' in line and '"frame"' not in printed:
                    deed(self)
                printed += line
        return self.command.returncode, printed


@pytest.fixture
def cluster() -> Iterator[Cluster]:
    made = Cluster()
    yield made
    made.kill()


def busy(cluster: Cluster) -> psutil.Process:
    """A worker that bakes."""
    return next(
        found for found in map(psutil.Process, [p.pid for p in cluster.processes[1:]]) if found.children()
    )


def fill_disks(cluster: Cluster) -> None:
    for worker in cluster.processes[1:3]:
        resource.prlimit(worker.pid, resource.RLIMIT_FSIZE, (10_000, 10_000))


DEEDS = {
    "a worker is killed": (lambda cluster: busy(cluster).kill(), ""),
    "Blender crashes": (
        lambda cluster: busy(cluster).children()[0].send_signal(signal.SIGSEGV),
        "status -11",
    ),
    "two disks are full": (fill_disks, '"failed"'),
    "the network of a worker is cut": (lambda cluster: busy(cluster).suspend(), ""),
    "the scheduler is killed": (lambda cluster: (cluster.kill(), cluster.start()), "scheduler lost"),
    "the command is killed": (lambda cluster: cluster.command.kill(), ""),
}


@pytest.mark.parametrize("deed", DEEDS)
def test_no_frame_is_lost(cluster: Cluster, shot: Path, tmp_path: Path, deed: str) -> None:
    status, printed = cluster.bake(shot, tmp_path, DEEDS[deed][0])
    assert DEEDS[deed][1] in printed, printed
    assert (status == 0) == ("command" not in deed), printed
    there = {file: file.stat().st_mtime_ns for file in tmp_path.glob("chunks/*.pc2")}
    if status:
        assert cluster.bake(shot, tmp_path, lambda cluster: None)[0] == 0
    assert (tmp_path / "Body.pc2").read_bytes() == shot.with_name("Body.pc2").read_bytes()
    assert there.items() <= {file: file.stat().st_mtime_ns for file in tmp_path.glob("chunks/*.pc2")}.items()
    assert len(list(tmp_path.glob("chunks/*"))) == 16


def test_a_refusal_ends_all_with_its_status(shot: Path, tmp_path: Path) -> None:
    words = ["--frames", "1-8", "--objects", "Nobody", "--out", tmp_path, "--blender", BLENDER]
    assert said(*FARM, "dask", shot, "--workers", "2", *words, code=3).count("failed on") < 4
    assert list(tmp_path.glob("**/*.*")) == []


def test_the_job_type_of_flamenco_bakes_chunks_and_joins_after_all_of_them(
    shot: Path, tmp_path: Path
) -> None:
    settings = {
        "frames": "1-240",
        "objects": "Body",
        "format": "pc2",
        "out": str(tmp_path),
        "chunk_size": 100,
    }
    settings |= {"blendfile": str(shot), "threads": 1, "memory": 0, "script": "command.py"}
    tasks = json.loads(said("node", "-e", said(*FARM, "flamenco") + NODE, json.dumps(settings)))
    assert (
        tasks[-1]["after"]
        == ["bake-1-100", "bake-101-200", "bake-201-240"]
        == [t["name"] for t in tasks[:-1]]
    )
    for task in tasks:
        assert task["words"][:4] == ["--background", "--python", "command.py", "--"]
        said(*shlex.split(BLENDER), *task["words"][4:])
    assert (tmp_path / "Body.pc2").read_bytes() == shot.with_name("Body.pc2").read_bytes()


def test_the_template_of_openjd_is_valid_and_bakes(shot: Path, tmp_path: Path) -> None:
    template = tmp_path / "sinew.yaml"
    template.write_text(said(*FARM, "openjd"))
    said(OPENJD, "check", template, *CHUNKS)
    given = {"Shot": shot, "Out": tmp_path, "Objects": "Body", "Chunk": 100, "Blender": BLENDER, "Threads": 1}
    words = [
        OPENJD,
        "run",
        template,
        *CHUNKS,
        *(w for name, value in given.items() for w in ("-p", f"{name}={value}")),
    ]
    assert said(*words).count("openjd_progress: 100.0") == 3
    assert (tmp_path / "Body.pc2").read_bytes() == shot.with_name("Body.pc2").read_bytes()
    assert "openjd_fail: " in said(*words, "-p", "Objects=Nobody", code=1)


OLDER = ["--background", "--python", "/addons/sinew/farm/command.py", "--", "bake"]


@pytest.mark.parametrize(("release", "way"), [("4.2.0", ["--command", "sinew_bake"]), ("3.4.1", OLDER)])
def test_a_blender_is_started_in_the_way_of_its_release(tmp_path: Path, release: str, way: list[str]) -> None:
    blender = tmp_path / "blender"
    blender.write_text(
        f"#!/bin/sh\necho Blender {release}\necho sinew is in /addons/sinew/__init__.py\nexit 1\n"
    )
    blender.chmod(0o755)
    assert atom.command(f"{blender} -y", "bake", ["x"]) == [str(blender), "-y", *way, "x"]
    assert atom.run(str(blender), "bake", ["x"]).code == atom.REFUSED  # as it tells nothing of Sinew
