# SPDX-License-Identifier: GPL-3.0-or-later
"""Engines bake a shot to the bits of one process, also where their parts are killed."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from signal import SIGSEGV

import numpy as np
import psutil
import pytest

from sinew_farm import atom

HERE, BLENDER = Path(__file__).parent, os.environ["SINEW_ATOM"].split()  # Python with Blender, and command.py
FARM, OPENJD = [sys.executable, "-m", "sinew_farm"], Path(sys.executable).with_name("openjd")
WORDS = ["--frames", "1-240", "--objects", "Body", "--format", "pc2", "--out"]
READ = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
ADDRESS = f"tcp://127.0.0.1:{20_000 + os.getpid() % 10_000}"
# What is done to one worker that bakes, to the command, or to all processes; and what is printed then.
DEEDS = {
    "a worker is killed": (lambda one, command, every: one.kill(), ""),
    "a network is cut": (lambda one, command, every: one.suspend(), ""),
    "two disks are full": (
        lambda one, command, every: [each.rlimit(psutil.RLIMIT_FSIZE, (9999, 9999)) for each in every[1:3]],
        '"failed"',
    ),
    "Blender crashes": (lambda one, *_: one.children()[0].send_signal(SIGSEGV), "status -11"),
    "the scheduler is killed": (lambda one, command, every: restart(every), "scheduler lost"),
    "the command is killed": (lambda one, command, every: command.kill(), ""),
}


def said(*words: object, code: int = 0) -> str:
    limit = None if "SINEW_LONG_TESTS" in os.environ else 300.0
    ended = subprocess.run(list(map(str, words)), timeout=limit, **READ)
    assert ended.returncode == code, ended.stdout
    return ended.stdout


@pytest.fixture(scope="module")
def shot(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A shot, and beside it what one process bakes of it."""
    file = tmp_path_factory.mktemp("shot") / "shot.blend"
    said(BLENDER[0], HERE / "make_shot.py", file, 40)
    said(*BLENDER, "bake", file, *WORDS, file.parent)
    said(*BLENDER, "join", file.parent, *WORDS, file.parent)
    return file


def same(shot: Path, out: Path) -> bool:
    return (out / "Body.pc2").read_bytes() == shot.with_name("Body.pc2").read_bytes()


def restart(processes: list[psutil.Popen], count: int = 4) -> None:
    """Ends all processes, and starts a scheduler with workers."""
    for process in processes:
        process.kill()
    env = os.environ | {"DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": "10s"}
    starts = [["scheduler", "--host"], *[["worker", "--nthreads", "1", "--no-nanny"]] * 4][: count + 1]
    commands = [[*FARM[:2], "dask", *words, ADDRESS, "--no-dashboard"] for words in starts if count]
    processes[:] = [psutil.Popen(command, env=env, stderr=subprocess.DEVNULL) for command in commands]


@pytest.mark.parametrize("deed", DEEDS)
def test_no_frame_is_lost_and_none_that_is_there_is_baked_again(shot, tmp_path, request, deed: str) -> None:
    restart(processes := [])
    request.addfinalizer(lambda: restart(processes, 0))
    do, says = DEEDS[deed]
    words = [*FARM, "dask", shot, "--chunk", "30", "--scheduler", ADDRESS, "--blender", " ".join(BLENDER)]
    with subprocess.Popen([*words, "--json", *WORDS, tmp_path], **READ) as command:
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
        said(*BLENDER, *task["words"][4:])
    assert same(shot, tmp_path)


def test_the_template_of_openjd_is_valid_and_bakes(shot: Path, tmp_path: Path) -> None:
    (tmp_path / "sinew.yaml").write_text(said(*FARM, "openjd"))
    words = [tmp_path / "sinew.yaml", "--extensions", "TASK_CHUNKING"]
    said(OPENJD, "check", *words)
    given = {"Shot": shot, "Out": tmp_path, "Objects": "Body", "Chunk": 100, "Blender": " ".join(BLENDER)}
    words += [word for name, value in given.items() for word in ("-p", f"{name}={value}")]
    assert said(OPENJD, "run", *words).count("openjd_progress: 100.0") == 3
    assert same(shot, tmp_path)
    assert "openjd_fail: " in said(OPENJD, "run", *words, "-p", "Objects=Nobody", code=1)


def test_chunks_of_an_older_processor_say_so_and_are_not_mixed_unasked(shot: Path, tmp_path: Path) -> None:
    for program, frames in ((["qemu-x86_64-static", "-cpu", "Nehalem"], "1-2"), ([], "3-4")):
        said(*program, *BLENDER, "bake", shot, *WORDS, tmp_path, "--frames", frames)
    kernels = [json.loads(file.read_text())["kernels"] for file in sorted(tmp_path.glob("chunks/*.json"))]
    assert kernels[0] == "sse4.2" != kernels[1]
    join = [*BLENDER, "join", tmp_path, *WORDS, tmp_path, "--frames", "1-4"]
    assert "kernels sse4.2" in said(*join, code=5)
    said(*join, "--mixed")


@pytest.fixture
def ssh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """An SSH server of this machine, for the one key that the user has."""
    folder, port = tmp_path / ".ssh", str(30_000 + os.getpid() % 10_000)
    folder.mkdir()
    if os.geteuid() == 0:  # then only, the server asks for this
        Path("/run/sshd").mkdir(exist_ok=True)
    said("ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", folder / "id_ed25519")
    public = (folder / "id_ed25519.pub").read_text()
    for name, text in {
        "known_hosts": f"[127.0.0.1]:{port} {public}",
        "config": f"Host *\n  Port {port}\n",
    }.items():
        (folder / name).write_text(text)
    monkeypatch.setenv("HOME", str(tmp_path))
    given = [
        f"AuthorizedKeysFile={folder}/id_ed25519.pub",
        "StrictModes=no",
        "ListenAddress=127.0.0.1",
        "PidFile=none",
    ]
    passed = ("PYTHONPATH", "BLENDER_USER_RESOURCES", "SINEW_ADDON_MODULE")
    given.append("SetEnv=" + " ".join(f"{name}={os.environ[name]}" for name in passed))
    options = [word for option in given for word in ("-o", option)]
    with subprocess.Popen(
        ["/usr/sbin/sshd", "-D", "-p", port, "-h", folder / "id_ed25519", *options]
    ) as server:
        yield ["--hosts", "127.0.0.1,127.0.0.1,127.0.0.1"]
        server.kill()


@pytest.fixture
def slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What Dask needs of SLURM: its jobs begin at once, on this machine."""
    for name, does in {"sbatch": '(sh "$1" 2>&1 &) > log; echo Submitted batch job 1', "scancel": ""}.items():
        (tmp_path / name).write_text(f"#!/bin/sh\ncd {tmp_path}; {does}\n")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    return ["--threads", "1", "--memory", "2"]


@pytest.mark.parametrize("kind", ["ssh", "slurm"])
def test_clusters_of_dask_bake_the_same(shot: Path, tmp_path: Path, kind: str, request) -> None:
    how = ["--cluster", kind, "--workers", 2, "--blender", " ".join(BLENDER), *request.getfixturevalue(kind)]
    said(*FARM, "dask", shot, *how, *WORDS, tmp_path)
    assert same(shot, tmp_path)


def test_a_refusal_ends_all_with_its_status(shot: Path, tmp_path: Path) -> None:
    words = ["--workers", 2, "--blender", " ".join(BLENDER), *WORDS, tmp_path, "--objects", "Nobody"]
    assert said(*FARM, "dask", shot, *words, code=3).count("failed on") < 4
    assert not list(tmp_path.glob("**/*.*"))
    lacks = said(*FARM, "dask", shot, *WORDS, tmp_path, "--cluster", "no_such:Cluster", code=1)
    assert "needs a package: pip install no-such" in lacks
    bakes = tmp_path / "bakes"  # for ever, but for the first frames, which are refused
    bakes.write_text(
        '#!/bin/sh\ncase "$*" in *--version) echo Blender 4.2;; *" 1-"*) exit 3;; *) sleep 9999; esac'
    )
    bakes.chmod(0o755)
    said(*FARM, "dask", shot, *words[:2], "--blender", bakes, *WORDS, tmp_path, code=3)
    assert not [
        each for each in psutil.process_iter(["cmdline"]) if str(bakes) in (each.info["cmdline"] or ())
    ]


@pytest.mark.skipif("SINEW_LONG_TESTS" not in os.environ, reason="it takes gigabytes, and minutes")
@pytest.mark.parametrize("side", [2236, 3163])
def test_millions_of_vertices_are_posed_and_baked(side: int, tmp_path: Path) -> None:
    shot = tmp_path / "shot.blend"
    said(BLENDER[0], HERE / "make_shot.py", shot, side, "multigrid")
    print(said(*BLENDER, "bake", shot, *WORDS, tmp_path, "--frames", "120-121"))
    said(*BLENDER, "join", tmp_path, *WORDS, tmp_path, "--frames", "120-121")
    heights = np.fromfile(tmp_path / "Body.pc2", "<f4", offset=32).reshape(2, side, side, 3)[..., 2]
    assert np.ptp(heights, axis=2).max() < 1e-4  # no strip along the handles bends
    assert np.diff(heights.mean(axis=2), axis=1).min() > -1e-6  # from the fixed one to the handle all rise
    assert np.ptp(heights[:, 0]) == 0 < heights[:, -1].min()


def test_a_blender_is_started_in_the_way_of_its_release(tmp_path: Path) -> None:
    blender, older = tmp_path / "blender", "--background --python /sinew/farm/command.py -- bake"
    for release, way in (("4.2.0", "--command sinew_bake"), ("3.4.1", older)):
        blender.write_text(f"#!/bin/sh\necho Blender {release}\necho sinew is in /sinew/a.py\nexit 1\n")
        blender.chmod(0o755)
        words = atom.command(f"{blender} -{release}", "bake", ["x"])
        assert words == [str(blender), f"-{release}", *way.split(), "x"]
    assert atom.run(str(blender), "bake", ["x"]).code == atom.REFUSED  # as it tells nothing of Sinew
