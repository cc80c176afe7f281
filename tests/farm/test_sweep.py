# SPDX-License-Identifier: GPL-3.0-or-later
"""Sweeps on a Dask cluster: the shapes of ``sinew_native.deform``, each made once."""

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
from sinew_farm.sweep import Cache, Sweep, bind_surface

EXAMPLES = Path(__file__).parents[2] / "examples"
sys.path.insert(0, str(EXAMPLES))

from shapes import shapes


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    quiet = {"dashboard_address": ":0", "silence_logs": logging.CRITICAL}
    with LocalCluster(n_workers=2, threads_per_worker=1, **quiet) as cluster, Client(cluster) as made:
        yield made


@pytest.fixture
def sweep(tmp_path: Path) -> Sweep:
    """That of the example, on a strip of quads."""
    quads = [(i, i + 1, i + 4, i + 3) for row in range(29) for i in (3 * row + 1, 3 * row + 2)]
    lines = [f"v {x} {0.1 * x * z} {z}" for z in range(30) for x in range(3)]
    lines += [f"f {' '.join(map(str, quad))}" for quad in quads]
    (tmp_path / "strip.obj").write_text("\n".join(lines))
    return shapes(str(tmp_path / "strip.obj"), str(tmp_path / "shapes"))


def test_the_example_makes_what_is_missing_of_its_200_shapes(
    client: Client, sweep: Sweep, tmp_path: Path
) -> None:
    command = [sys.executable, EXAMPLES / "shapes.py", "strip.obj", "shapes", client.scheduler.address]
    said = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True).stdout
    assert said == "200 shapes are in shapes\n"
    (mesh,), files = sweep.meshes.values(), sorted(sweep.out.glob("*.obj"))
    made = {file.name: file.read_bytes() for file in files}
    assert len(set(made.values())) == 200
    for name in list(sweep.poses)[::40]:
        expected = sinew_native.deform(
            mesh.points, mesh.faces, mesh.handles, sweep.poses[name], method="arap"
        )
        found = np.loadtxt(sweep.out / f"strip,{name}.obj", max_rows=90, usecols=(1, 2, 3))
        np.testing.assert_array_equal(found, expected)

    files[3].write_bytes(b"half")
    files[7].unlink()
    kept = {file: file.stat().st_mtime_ns for file in files if file not in (files[3], files[7])}
    sweep.run(client)
    assert {file: file.stat().st_mtime_ns for file in kept} == kept
    assert {file.name: file.read_bytes() for file in files} == made
    assert len(list(sweep.out.iterdir())) == 400  # with their manifests


@pytest.mark.parametrize(
    ("changed", "says", "made"),
    [
        (
            {"poses": {"far": np.full((2, 3, 4), np.nan), "rest": np.tile(np.eye(3, 4), (2, 1, 1))}},
            "strip,far",
            1,
        ),
        ({"parameters": {"method": ["none"]}}, "200 of 200 results failed; .* no surface method 'none'", 0),
        ({"format": "stl"}, "format: 'stl' is neither npy nor obj", 0),
    ],
)
def test_what_fails_is_named_and_all_else_is_made(
    client: Client, sweep: Sweep, changed: dict, says: str, made: int
) -> None:
    with pytest.raises(FarmError, match=says):
        Sweep(**(vars(sweep) | changed)).run(client)
    assert len(list(sweep.out.glob("*.obj"))) == made


def test_a_worker_forgets_what_was_used_longest_ago(sweep: Sweep) -> None:
    cache, made = Cache(), []
    one = bind_surface(sweep.meshes["strip"])
    for key in "abacab":
        cache.get(key, lambda key=key: made.append(key) or one, 2 * one.nbytes)
    assert made == ["a", "b", "c", "b"]
