# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes on engines whose parts are killed, with a program that stands in for Blender."""

import json
import os
import re
import resource
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from sinew_farm import atom

BLENDER = Path(__file__).with_name("blender")
FRAMES = b"".join(frame.to_bytes(4, "big") * 500 for frame in range(1, 25))
FARM = [sys.executable, "-m", "sinew_farm"]
WORKER_TTL = {"DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": "10s"}


def said(words: list[str | Path]) -> str:
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout


class Farm:
    """A scheduler with workers, each a process, and the command that bakes on them."""

    def __init__(self, out: Path) -> None:
        self.out = out
        with socket.create_server(("127.0.0.1", 0)) as found:
            self.port = found.getsockname()[1]
        self.processes: list[subprocess.Popen] = []
        self.set_up()

    def set_up(self) -> None:
        address = f"tcp://127.0.0.1:{self.port}"
        scheduler = ["scheduler", "--host", "127.0.0.1", "--port", str(self.port), "--no-dashboard"]
        worker = ["worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        self.processes = [self._dask(words) for words in (scheduler, *[worker] * 4)]

    def _dask(self, words: list[str]) -> subprocess.Popen:
        env = os.environ | WORKER_TTL | {"SECONDS": "0.1"}
        sink = subprocess.DEVNULL
        return subprocess.Popen([sys.executable, "-m", "dask", *words], env=env, stdout=sink, stderr=sink)

    def close(self) -> None:
        for process in self.processes:
            process.kill()
            process.wait()

    def bake(
        self, deed: Callable[["Farm"], None] = lambda farm: None, objects: str = "Body"
    ) -> tuple[int, str]:
        """The exit status and what was printed; the deed is done once a first chunk is there."""
        words = ["shot.blend", "--frames", "1-24", "--objects", objects, "--chunk", "2", "--json"]
        words += ["--scheduler", f"tcp://127.0.0.1:{self.port}", "--out", self.out, "--blender", BLENDER]
        command = [*FARM, "dask", *words]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as baking:
            self.command, printed = baking, ""
            for line in baking.stdout:
                if '"ended"' in line and '"ended"' not in printed:
                    deed(self)
                printed += line
        return baking.returncode, printed


@pytest.fixture
def farm(tmp_path: Path) -> Iterator[Farm]:
    made = Farm(tmp_path)
    yield made
    made.close()


def restart(farm: Farm) -> None:
    farm.close()
    farm.set_up()


def fill_disk(farm: Farm) -> None:
    resource.prlimit(farm.processes[1].pid, resource.RLIMIT_FSIZE, (1000, 1000))


DEEDS = {
    "nothing": lambda farm: None,
    "a worker is killed": lambda farm: farm.processes[1].kill(),
    "the disk of a worker is full": fill_disk,
    "the network of a worker is cut": lambda farm: farm.processes[1].send_signal(signal.SIGSTOP),
    "the scheduler is killed, and started again": restart,
    "the command itself is killed": lambda farm: farm.command.kill(),
}


@pytest.mark.parametrize("deed", DEEDS)
def test_no_frame_is_lost_and_what_is_there_is_not_baked_again(farm: Farm, deed: str) -> None:
    status, printed = farm.bake(DEEDS[deed])
    assert status == (-signal.SIGKILL if "command" in deed else 0), printed
    assert ("File too large" in printed, "scheduler lost" in printed) == ("disk" in deed, "scheduler" in deed)
    ended = re.findall(r'"ended", "part": "(\d+-\d+)"', printed)
    assert farm.bake()[0] == 0
    assert (farm.out / "joined").read_bytes() == FRAMES
    baked = (farm.out / "baked").read_text().split()
    assert len(set(baked)) == 12
    assert len(ended) == 12 or "command" in deed
    if "worker" not in deed:  # whose chunk may be baked twice at the same time
        assert all(baked.count(f"Body.{part}.pc2") == 1 for part in ended)


@pytest.mark.parametrize(
    ("objects", "code", "says", "refusals"),
    [("Nobody", 3, "no object is called Nobody", {"once"}), ("Wrecked", 0, "ended with status -11", set())],
)
def test_a_refusal_ends_all_with_its_code_and_a_crash_is_tried_again(
    farm: Farm, objects: str, code: int, says: str, refusals: set[str]
) -> None:
    status, printed = farm.bake(objects=objects)
    assert (status, says in printed) == (code, True), printed
    assert {path.read_text().strip() for path in farm.out.glob("refused-*")} == refusals


NODE = """
class Task {
    constructor(name) { Object.assign(this, { name, commands: [], after: [] }); }
    addCommand(command) { this.commands.push(command.args); }
    addDependency(task) { this.after.push(task.name); }
}
const author = { Task: (name) => new Task(name), Command: (name, words) => words }, tasks = [];
compileJob({ settings: JSON.parse(process.argv[1]), addTask: (task) => tasks.push(task) });
console.log(JSON.stringify(tasks));
"""
WORDS = {"frames": "1-24", "objects": "Body", "format": "pc2", "threads": 1, "memory": 1.5, "chunk_size": 5}


@pytest.mark.parametrize("script", ["", "/addons/sinew/farm/command.py"])
def test_the_job_type_of_flamenco_bakes_chunks_and_joins_after_all_of_them(
    tmp_path: Path, script: str
) -> None:
    settings = json.dumps({**WORDS, "blendfile": "shot.blend", "out": str(tmp_path), "script": script})
    *bakes, join = json.loads(said(["node", "-e", said([*FARM, "flamenco"]) + NODE, settings]))
    assert join["after"] == [f"bake-{part}" for part in ("1-5", "6-10", "11-15", "16-20", "21-24")]
    for task in (*bakes, join):
        said([BLENDER, *task["commands"][0]])
    assert (tmp_path / "joined").read_bytes() == FRAMES


def test_the_template_of_openjd_is_valid_and_bakes(tmp_path: Path) -> None:
    template, openjd = tmp_path / "sinew.yaml", Path(sys.executable).with_name("openjd")
    template.write_text(said([*FARM, "openjd"]))
    extension = ["--extensions", "TASK_CHUNKING"]
    said([openjd, "check", template, *extension])
    given = {
        "Shot": "shot.blend",
        "Out": tmp_path,
        "Objects": "Body",
        "Frames": "1-24",
        "Chunk": 5,
        "Blender": BLENDER,
    }
    given = [word for name, value in given.items() for word in ("-p", f"{name}={value}")]
    told = said([openjd, "run", template, *extension, *given])
    assert (tmp_path / "joined").read_bytes() == FRAMES
    assert told.count("openjd_progress: 100.0") == 5
    refused = subprocess.run(
        [openjd, "run", template, *extension, *given, "-p", "Objects=Nobody"], stdout=subprocess.PIPE
    )
    assert b"openjd_fail: no object is called Nobody" in refused.stdout


@pytest.mark.parametrize(
    ("release", "words"),
    [
        ("4.2.0", ["--command", "sinew_bake"]),
        ("3.4.1", ["--background", "--python", "/addons/sinew/farm/command.py", "--", "bake"]),
    ],
)
def test_a_blender_is_started_in_the_way_of_its_release(monkeypatch, release: str, words: list[str]) -> None:
    monkeypatch.setenv("RELEASE", release)
    blender = f"{BLENDER} --factory-startup" if release == "4.2.0" else str(BLENDER)
    assert atom.command(blender, "bake", ["x"]) == [*blender.split(), *words, "x"]
