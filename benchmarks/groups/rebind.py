# SPDX-License-Identifier: GPL-3.0-or-later
"""The time of a small change of a bound thin shell (a handle, painted stiffness), next to a new bind."""

import numpy as np
from cases import Case, bar, patch
from record import Row
from timing import Work, alternate

import sinew_native

from . import Options, Task

CHANGED = 100  # vertices


def plan(options: Options) -> list[Task]:
    size = 10_000 if options.quick else 100_000
    keywords = {"size": size, "threads": options.threads}
    return [
        Task("rebind", (work,), {"work": work, **keywords}) for work in ("handle_added", "stiffness_painted")
    ]


def measure(work: str, size: int, threads: list[int]) -> list[Row]:
    case = bar("bend 90", size)
    make = {"handle_added": _handle_added, "stiffness_painted": _stiffness_painted}[work]
    works = {(who, count): one for count in threads for who, one in make(case, count).items()}
    alternate(works, budget=12.0, most=8)
    return [
        {
            "work": work,
            "size": size,
            "threads": count,
            "vertices": case.vertex_count,
            "unit": "s",
            "ours": works["ours", count].best,
            "peer": works["peer", count].best,
        }
        for count in threads
    ]


class Change:
    """A new shell for each turn, which is bound before the turn or not."""

    def __init__(self, case: Case, threads: int) -> None:
        self.mesh = sinew_native.SurfaceMesh(case.points, case.faces)
        self.case, self.threads = case, threads

    def fresh(self, **options: object) -> None:
        sinew_native.limit_threads(self.threads)
        self.shell = sinew_native.ThinShell(self.mesh, affine_basis=False, **options)

    def bound(self, **options: object) -> None:
        self.fresh(**options)
        self.shell.set_handles(self.case.handles)


def _handle_added(case: Case, threads: int) -> dict[str, Work]:
    handles = [*case.handles, patch(case, CHANGED)]
    ours, peer = Change(case, threads), Change(case, threads)
    return {
        "ours": Work(lambda: ours.shell.set_handles(handles), ours.bound, repeatable=False),
        "peer": Work(lambda: peer.shell.set_handles(handles), peer.fresh, repeatable=False),
    }


def _stiffness_painted(case: Case, threads: int) -> dict[str, Work]:
    before = np.ones(case.vertex_count)
    after = before.copy()
    after[patch(case, CHANGED)] = 10.0
    ours, peer = Change(case, threads), Change(case, threads)
    return {
        "ours": Work(
            lambda: ours.shell.set_stiffness(0.0, after),
            lambda: ours.bound(bending=before),
            repeatable=False,
        ),
        "peer": Work(
            lambda: peer.shell.set_handles(case.handles),
            lambda: peer.fresh(bending=after),
            repeatable=False,
        ),
    }
