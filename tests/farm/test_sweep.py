# SPDX-License-Identifier: GPL-3.0-or-later
"""Sweeps on a Dask cluster: the shapes of ``sinew_native.deform``, each made once."""

import importlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from distributed import Client

import sinew_native
from sinew_farm.errors import FarmError
from sinew_farm.sweep import Cache, Sweep, bind_surface

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture
def sweep(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Sweep:
    """That of the example, on a strip of quads."""
    monkeypatch.syspath_prepend(EXAMPLES)
    lines = [f"v {x} {0.1 * x * z} {z}" for z in range(30) for x in range(3)]
    lines += [f"f {i} {i + 1} {i + 4} {i + 3}" for i in range(1, 87) if i % 3]
    (tmp_path / "strip.obj").write_text("\n".join(lines))
    return importlib.import_module("shapes").shapes(str(tmp_path / "strip.obj"), str(tmp_path / "out"))


def test_the_example_makes_what_is_missing_of_its_200_shapes(sweep: Sweep, tmp_path: Path) -> None:
    (mesh,), seen, half = sweep.meshes.values(), [], sweep.out / f"strip,{min(sweep.poses)}.obj"
    for _run in range(2):
        words = [sys.executable, EXAMPLES / "shapes.py", "strip.obj", "out"]
        assert subprocess.check_output(words, cwd=tmp_path, text=True) == "200 shapes are in out\n"
        seen.append({file: (file.read_bytes(), file.stat().st_mtime_ns) for file in sweep.out.glob("*.obj")})
        for name in list(sweep.poses)[::40]:
            expected = sinew_native.deform(mesh.points, mesh.faces, mesh.handles, sweep.poses[name], "arap")
            found = np.loadtxt(sweep.out / f"strip,{name}.obj", max_rows=90, usecols=(1, 2, 3))
            np.testing.assert_array_equal(found, expected)
        half.write_bytes(b"half")
    assert len({content for content, _ in seen[1].values()}) == 200
    assert {file for file in seen[0] if seen[0][file] != seen[1][file]} == {half}


def test_what_fails_is_named_and_all_else_is_made(sweep: Sweep) -> None:
    poses = {"nowhere": np.full((2, 3, 4), np.nan), "rest": np.tile(np.eye(3, 4), (2, 1, 1))}
    with Client(n_workers=1, dashboard_address=":0") as client:
        for changed, says in (({}, "1 of 2 results failed; strip,nowhere"), ({"method": ["none"]}, "'none'")):
            with pytest.raises(FarmError, match=says):
                Sweep(sweep.meshes, poses, sweep.out, changed).run(client)
    assert [file.name for file in sweep.out.glob("*.npy")] == ["strip,rest.npy"]


def test_a_worker_forgets_what_was_used_longest_ago(sweep: Sweep) -> None:
    cache, made, bound = Cache(), [], bind_surface(sweep.meshes["strip"])
    for key in "abacab":
        cache.get(key, lambda key=key: made.append(key) or bound, 2 * bound.nbytes)
    assert made == ["a", "b", "c", "b"]
