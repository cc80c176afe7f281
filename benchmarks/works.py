# SPDX-License-Identifier: GPL-3.0-or-later
"""What is measured, next to what, and what is wanted."""

from collections.abc import Mapping
from dataclasses import dataclass

from record import Row

CONVERGENCE_BUDGETS = (0, 4, 10, 20, 40)  # iterations after which the excess energy is told
ANY = 0  # a size that stands for all others
Wanted = Mapping[int, float | tuple[float, float]]  # nominal vertices -> on any, or on one and two threads


@dataclass(frozen=True)
class Work:
    id: str
    what: str
    peer: str
    wanted: Wanted
    noise: float = 0.0  # what two measurements of one thing differ by, where a tie is good enough
    at_most: bool = False  # the ratio is ours / peer and small is good; else peer / ours and large is good

    def ratio(self, row: Row) -> float:
        ours, peer = float(row["ours"]), float(row["peer"])
        return ours / peer if self.at_most else peer / ours

    def goal(self, row: Row) -> float | None:
        found = self.wanted.get(row["size"], self.wanted.get(ANY))
        if isinstance(found, tuple):
            return found[min(int(row.get("threads") or 1), 2) - 1]
        return found

    def met(self, row: Row) -> bool | None:
        """None where nothing is wanted."""
        goal = self.goal(row)
        if goal is None:
            return None
        return self.ratio(row) <= goal if self.at_most else self.ratio(row) >= goal - self.noise


FRAME = "Laplacian Deform"
WORKS = (
    Work("bind", "`ThinShell.set_handles`", "CHOLMOD supernodal", {ANY: 1.0, 500_000: 1.2}),
    Work("bind_peak", "its peak memory", "CHOLMOD's", {ANY: 1.0}, at_most=True),
    Work("bind_ldlt", "`ThinShell.set_handles`", "Eigen LDLT", {50_000: 3.0, 200_000: 8.0}),
    Work("memory", "memory of a bound `ThinShell`", "CHOLMOD's factor alone", {500_000: 1.5}, at_most=True),
    Work("solve", "`ThinShell.solve`, x, y, z", "CHOLMOD's solve", {50_000: 1.5, 200_000: 1.5}),
    Work("solve_bound", "its time", "the bandwidth bound", {50_000: 2.5, 200_000: 2.5}, at_most=True),
    Work("basis_bound", "affine basis, 4 handles", "the bandwidth bound", {ANY: 0.5}),
    Work("handle_added", "a handle of 100 vertices more", "a new factor", {100_000: 2.0}),
    Work("stiffness_painted", "stiffness painted on 100 vertices", "a new factor", {100_000: 2.0}),
    Work(
        "arap_iteration",
        "`Arap` iteration, spokes and rims",
        "libigl",
        {10_000: (8.0, 12.0), 50_000: (8.0, 12.0), 200_000: (7.0, 11.0)},
    ),
    Work(
        "arap_spokes",
        "`Arap` iteration, spokes",
        "libigl",
        {10_000: (8.0, 12.0), 50_000: (8.0, 12.0), 200_000: (7.0, 11.0)},
    ),
    Work("arap_smooth", "with smooth rotations", "our own without", {ANY: 1.6}, at_most=True),
    Work("arap_bend", "`Arap` to 1 %, bar bent by 90 degrees", "libigl", {50_000: 50.0}),
    Work("arap_cold", "`Arap` to 1 %, armadillo", "4 iterations of libigl", {ANY: 1.0}),
    Work("subdivision", "`SubdivisionSurface.refine`", "OpenSubdiv's CPU evaluator", {ANY: 3.0}),
    Work("subdivision_blender", "the same", "frame of Blender's Subdivision modifier", {ANY: 4.0}),
    Work(
        "subdivision_frame", "the same, written and evaluated in Blender", "the modifier's frame", {ANY: 1.0}
    ),
    Work("cage_time", "`automatic_cage`, 300 faces", "two seconds", {ANY: 1.0}),
    Work(
        "cage_poking",
        "faces of the scan that meet it",
        "Blender's remesh, displace, decimate",
        {ANY: 0.0},
        at_most=True,
    ),
    Work("mean_value_double", "`MeanValue.bind`, double", "the paper's loop", {ANY: 7.0}),
    Work("mean_value", "`MeanValue.bind`", "the paper's loop, one thread", {ANY: (7.0, 20.0)}),
    Work("green", "`Green.bind`", "the paper's loop, one thread", {ANY: 50.0}),
    Work("cage_warp", "warp of a cage, single precision", "BLAS sgemm, one thread", {ANY: 1.5}),
    Work("frame_thin_shell", "frame in Blender, `thin_shell`", FRAME, {ANY: 20.0}),
    Work("frame_arap", "frame in Blender, `arap`", f"{FRAME}, repeat 3", {ANY: 8.0}),
    Work("frame_arap_3", "the same with 3 iterations", f"{FRAME}, repeat 3", {ANY: 8.0}),
    Work("frame_cage", "frame in Blender, `mean_value`, 296 cage vertices", "Mesh Deform", {ANY: 1.0}),
    Work("drag_arap", "the same while dragging", f"{FRAME}, repeat 3", {ANY: 8.0}),
    Work(
        "overhead_thin_shell", "frame less its solve, `thin_shell`", "a bare write", {ANY: 1.2}, at_most=True
    ),
    Work("overhead_arap", "frame less its solve, `arap` dragged", "a bare write", {ANY: 1.2}, at_most=True),
    Work("first_thin_shell", "bind + first frame, `thin_shell`", f"{FRAME}'s bind", {ANY: 10.0}),
    Work("first_arap", "bind + first frame, `arap`", f"{FRAME}'s bind", {ANY: 10.0}),
    Work(
        "reading_thin_shell", "reading a mesh of 1M, `thin_shell`", "its whole bind", {ANY: 0.1}, at_most=True
    ),
    Work("reading_arap", "reading a mesh of 1M, `arap`", "its whole bind", {ANY: 0.1}, at_most=True),
    Work("rebind_handle", "a handle more in Blender", "a new bind", {ANY: 2.0}),
    Work("rebind_stiffness", "stiffness painted in Blender", "a new bind", {ANY: 2.0}),
    Work("harmonic_5", "`Harmonic.bind`, 10k points", "Mesh Deform, precision 5", {ANY: 10.0}),
    Work("harmonic_error_5", "its largest error", "Mesh Deform's, precision 5", {ANY: 10.0}),
    Work("harmonic_6", "`Harmonic.bind`, 10k points", "Mesh Deform, precision 6", {ANY: 100.0}),
    Work("harmonic_error_6", "its largest error", "Mesh Deform's, precision 6", {ANY: 10.0}),
    Work("harmonic_large", "`Harmonic.bind`, 10k points, lattice", "boundary elements", {ANY: 1.0}),
    Work("harmonic_large_peak", "its peak memory", "that of the elements", {ANY: 1.0}, at_most=True),
    Work("positive_rays", "exact `PositiveMeanValue`, 300 faces", "4096 rays", {ANY: 1.0}),
    Work("positive_point", "its time a point", "200 microseconds", {ANY: 1.0}),
    Work("positive_error", "its error, to that of 8M rays", "that of 4096 rays", {ANY: 100.0}),
    Work("two_threads", "two threads", "one thread", {ANY: 1.0}, noise=0.03),
)
BY_ID = {work.id: work for work in WORKS}
# Works whose own time is that of a loop of ours: where two threads must not lose, and which have an exponent.
OWN_TIMES = {
    "bind": "bind",
    "solve": "solve",
    "basis_bound": "affine basis",
    "arap_iteration": "`Arap` iteration, spokes and rims",
    "arap_spokes": "`Arap` iteration, spokes",
    "arap_smooth": "`Arap` iteration, smooth",
    "arap_bend": "`Arap`, bend to 1 %",
    "arap_cold": "`Arap`, armadillo to 1 %",
    "subdivision": "subdivision",
    "handle_added": "a handle more",
    "stiffness_painted": "stiffness painted",
}


def two_thread_rows(rows: list[Row]) -> list[Row]:
    """One row a work and size that was measured on one and on two threads: ours on two, the peer on one."""
    ours = {(row["work"], row["size"], row.get("threads")): row for row in rows if row["work"] in OWN_TIMES}
    return [
        {
            "work": "two_threads",
            "case": work,
            "size": size,
            "vertices": row["vertices"],
            "ours": row["ours"],
            "peer": ours[work, size, 1]["ours"],
            "unit": "s",
        }
        for (work, size, threads), row in ours.items()
        if threads == 2 and (work, size, 1) in ours
    ]
