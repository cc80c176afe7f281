# SPDX-License-Identifier: GPL-3.0-or-later
"""Memory of a bound thin shell and of its bind, next to CHOLMOD's on the same matrix.

Sinew and CHOLMOD each run in a process of their own. The growth of the process is counted: for Sinew from the
mesh on, for CHOLMOD from the matrix on.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import scipy.sparse as sparse
from record import Row

from . import Options, Task


def plan(options: Options) -> list[Task]:
    tasks = [Task("memory", ("memory", "bind_peak"), {"size": size}) for size in options.sizes]
    own = [Task("memory", ("memory",), {"size": size, "peers": False}) for size in options.own_sizes]
    return [*tasks, *own]


def measure(size: int, peers: bool = True) -> list[Row]:
    with tempfile.TemporaryDirectory() as folder:
        matrix = Path(folder) / "matrix.npz"
        full, ours = (_apart("ours", size, basis) for basis in ("basis", "no basis"))
        row = {"size": size, "vertices": ours["vertices"], "unit": "bytes"}
        if not peers:
            return [{"work": "memory", **row, "ours": full["kept"], "ours_peak": full["peak"]}]
        _apart("matrix", size, matrix)
        peer = _apart("peer", matrix)
    return [
        {"work": "memory", **row, "ours": full["kept"], "peer": peer["factor"], "ours_peak": full["peak"]},
        {"work": "bind_peak", **row, "ours": ours["peak"], "peer": peer["peak"]},
    ]


def _apart(*words: object) -> dict[str, int]:
    command = [sys.executable, "-m", "groups.memory", *(str(word) for word in words)]
    folder = Path(__file__).resolve().parents[1]
    done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=folder)
    return json.loads(done.stdout)


def _status(field: str) -> int:
    """The memory of this process in bytes, from the kernel: VmRSS is the memory now, VmHWM the maximum."""
    for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
        if line.startswith(field + ":"):
            return 1024 * int(line.split()[1])
    raise SystemExit(f"no {field} in /proc/self/status")


class Growth:
    """The growth of this process since the object was made."""

    def __init__(self) -> None:
        Path("/proc/self/clear_refs").write_text("5", encoding="utf-8")  # resets VmHWM
        self._begin = _status("VmRSS")

    def counted(self) -> dict[str, int]:
        return {"kept": _status("VmRSS") - self._begin, "peak": _status("VmHWM") - self._begin}


def _ours(size: str, basis: str) -> dict[str, int]:
    from cases import bar

    import sinew_native

    case = bar("bend 90", int(size))
    growth = Growth()
    mesh = sinew_native.SurfaceMesh(case.points, case.faces)
    shell = sinew_native.ThinShell(mesh, affine_basis=basis == "basis")
    shell.set_handles(case.handles)
    return growth.counted() | {"vertices": case.vertex_count}


def _matrix(size: str, file: str) -> dict[str, int]:
    from cases import bar

    from .thin_shell import lower_matrix

    lower, _ = lower_matrix(bar("bend 90", int(size)))
    lower.sort_indices()
    np.savez(file, offsets=lower.indptr, rows=lower.indices, values=lower.data)
    return {}


def _peer(file: str) -> dict[str, int]:
    from .thin_shell import cholmod

    growth = Growth()
    with np.load(file) as stored:
        offsets = stored["offsets"]
        n = len(offsets) - 1
        lower = sparse.csc_matrix((stored["values"], stored["rows"], offsets), shape=(n, n))
    peer = cholmod(lower)
    peer.factorize()
    return growth.counted() | {"factor": peer.bytes}


if __name__ == "__main__":
    role, *words = sys.argv[1:]
    print(json.dumps({"ours": _ours, "matrix": _matrix, "peer": _peer}[role](*words)))
