# SPDX-License-Identifier: GPL-3.0-or-later
"""Sweeps on a Dask cluster: the shapes of ``sinew_native.deform``, each made once."""

import json
import logging
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from distributed import Client, LocalCluster

import sinew_native
from sinew_farm.errors import FarmError
from sinew_farm.sweep import Cache, Mesh, Sweep, bind_surface

EXAMPLE = Path(__file__).parents[2] / "examples" / "shapes.py"


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    quiet = {"dashboard_address": ":0", "silence_logs": logging.CRITICAL}
    with LocalCluster(n_workers=2, threads_per_worker=1, **quiet) as cluster, Client(cluster) as made:
        yield made


def bar(height: int) -> Mesh:
    """A strip of quads, held at its low end and moved at its high one."""
    points = np.array([(x, 0.1 * x * z, z) for z in range(height) for x in range(3)], float)
    quads = [
        (3 * z + x, 3 * z + x + 1, 3 * z + x + 4, 3 * z + x + 3) for z in range(height - 1) for x in (0, 1)
    ]
    faces = np.full(len(quads), 4), np.ravel(quads)
    return Mesh(points, faces, [np.arange(3), np.arange(3 * height - 3, 3 * height)])


def lifted(by: float) -> np.ndarray:
    poses = np.tile(np.eye(3, 4), (2, 1, 1))
    poses[1, :, 3] = by
    return poses


def make(out: Path, **changed) -> Sweep:
    poses = {f"up {by}": lifted(by) for by in (0.0, 0.5, 1.0)}
    words = {"parameters": {"smoothness": [0.0, 0.01]}} | changed
    return Sweep({"low": bar(6), "high": bar(9)}, poses, out, **words)


def test_each_result_is_that_of_one_call_and_only_what_is_missing_is_made_again(
    client, tmp_path: Path
) -> None:
    files = make(tmp_path).run(client)
    assert len(files) == len(set(files)) == 12
    for file in files:
        name, smoothness, up = file.stem.split(",")
        mesh = bar({"low": 6, "high": 9}[name])
        said = {"method": "arap", "smoothness": float(smoothness.partition("=")[2])}
        poses = lifted(float(up.partition("_")[2]))
        expected = sinew_native.deform(mesh.points, mesh.faces, mesh.handles, poses, **said)
        np.testing.assert_array_equal(np.load(file), expected)
    assert client.submit(lambda: len(sys.modules["sinew_farm.sweep"].CACHE.kept)).result() <= 4

    files[3].write_bytes(b"half")
    files[7].unlink()
    before = [file.stat().st_mtime_ns for file in files if file.exists()]
    assert make(tmp_path).run(client) == files
    assert sum(file.stat().st_mtime_ns not in before for file in files) == 2
    assert {path.suffix for path in tmp_path.iterdir()} == {".npy", ".json"}
    told = json.loads(files[3].with_name(f"{files[3].name}.json").read_text())
    assert told["points"] == 18


def refuse_the_highest(bound, pose: np.ndarray) -> np.ndarray:
    if pose[1, 0, 3] == 1.0:
        raise ValueError("too high")
    return bound.method.solve(pose)[0]


@pytest.mark.parametrize(
    ("changed", "says", "made"),
    [
        ({"solve": refuse_the_highest}, "4 of 12 results failed; low,smoothness=0.0,up_1.0.npy: too high", 8),
        ({"parameters": {"method": ["none"]}}, "6 of 6 results failed; .*no surface method 'none'", 0),
        ({"format": "stl"}, "format: 'stl' is neither npy nor obj", 0),
        ({"meshes": {"a b": bar(3), "a_b": bar(4)}}, "names that make the same file", 0),
    ],
)
def test_what_fails_is_named_and_all_else_is_made(
    client, tmp_path: Path, changed, says: str, made: int
) -> None:
    with pytest.raises(FarmError, match=says):
        Sweep(**(vars(make(tmp_path)) | changed)).run(client)
    assert len(list(tmp_path.glob("*.npy"))) == made


def test_a_worker_forgets_what_was_used_longest_ago() -> None:
    cache, made, one = Cache(), [], bind_surface(bar(6))

    def get(*keys: str) -> None:
        for key in keys:
            cache.get(key, lambda key=key: made.append(key) or one, 2 * one.nbytes)

    get("a", "b", "a", "c", "a", "b")
    assert made == ["a", "b", "c", "b"]


def test_the_example_makes_200_shapes(client, tmp_path: Path) -> None:
    mesh = bar(30)
    lines = ["v {} {} {}".format(*point) for point in mesh.points]
    lines += ["f " + " ".join(map(str, face + 1)) for face in mesh.faces[1].reshape(-1, 4)]
    (tmp_path / "bar.obj").write_text("\n".join(lines))
    words = [sys.executable, EXAMPLE, "bar.obj", "shapes", client.scheduler.address]
    ended = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert (ended.returncode, ended.stdout) == (0, "200 shapes are in shapes\n"), ended.stderr
    assert len({path.read_bytes() for path in (tmp_path / "shapes").glob("*.obj")}) == 200
