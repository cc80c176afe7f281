# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of what is measured: in words, next to which peer, by which function, and the ratio wanted."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from record import Row

ANY = 0  # the size that stands for all other sizes
# Nominal vertices -> ratio, or ratios on one and two threads.
Wanted = Mapping[int, float | tuple[float, float]]
WITH_PEERS = (10_000, 50_000, 200_000, 500_000)
ALL = (*WITH_PEERS, 1_000_000, 2_000_000)  # the largest meshes are measured without their peers


@dataclass(frozen=True)
class Work:
    """A row. Stored results name its ``id``; ``what`` and ``peer`` are for readers. ``measure`` names a
    function in a module of ``rows/``, which gets a size and the numbers of threads. Works that name the same
    one share its runs."""

    id: str
    what: str
    peer: str  # nothing: a count that is compared with nothing, in a table of its own
    measure: str
    sizes: tuple[int, ...]
    wanted: Wanted = field(default_factory=dict)
    # The ratio is ours / peer, and small is good; else it is peer / ours, and large is good.
    at_most: bool = False

    def ratio(self, row: Row) -> float:
        ours, peer = float(row["ours"]), float(row["peer"])
        return ours / peer if self.at_most else peer / ours

    def goal(self, row: Row) -> float | None:
        found = self.wanted.get(row["size"], self.wanted.get(ANY))
        if isinstance(found, tuple):
            return found[min(int(row.get("threads") or 1), 2) - 1]
        return found

    def met(self, row: Row) -> bool | None:
        """Whether the ratio is as wanted; None if no ratio is wanted."""
        goal = self.goal(row)
        if goal is None:
            return None
        return self.ratio(row) <= goal if self.at_most else self.ratio(row) >= goal


WORKS = (
    Work("bind", "binding `ThinShell`", "CHOLMOD's supernodal factor",
         "factors.bind", ALL, {ANY: 1.0, 500_000: 1.2}),
    Work("memory", "memory of a bound `ThinShell`", "CHOLMOD's factor alone",
         "factors.memory", ALL, {500_000: 1.5}, at_most=True),
    Work("solve", "`ThinShell.solve`", "CHOLMOD's solve",
         "factors.solve", ALL, {50_000: 1.5, 200_000: 1.5}),
    Work("arap_iteration", "one iteration of `Arap`, spokes and rims", "libigl",
         "nonlinear.arap", ALL),
    Work("arap_bend", "`Arap` to 1 % above its least energy, bar bent by 90 degrees", "libigl",
         "nonlinear.bend", (50_000,), {50_000: 50.0}),
    Work("shell_iteration", "one iteration of `ThinShellNonlinear`", "one of `Arap`, spokes",
         "nonlinear.shell", WITH_PEERS[:3], {ANY: 3.0}, at_most=True),
    Work("pyramid_iteration", "one iteration of `PyramidCoordinates`", "one of `Arap`, spokes",
         "nonlinear.pyramid", WITH_PEERS, {ANY: 1.5}, at_most=True),
    Work("primo_iteration", "one iteration of `Primo`", "one of `Arap` with smooth rotations",
         "nonlinear.primo", WITH_PEERS, {ANY: 2.5}, at_most=True),
    Work("sequence_frame", "a frame of `MeshSequence`", "`Arap.solve` for the same poses",
         "surface.sequence", (10_000, 50_000), {ANY: 1.05}, at_most=True),
    Work("skeleton_pose", "the slowest of 30 poses by `Skeleton.solve`, 60 bones", "a limit of 30 ms",
         "surface.skeleton", (60,), {ANY: 1.0}, at_most=True),
    Work("subdivision", "`SubdivisionSurface.refine`, a million vertices", "OpenSubdiv's CPU evaluator",
         "surface.subdivision", (1_000_000,), {ANY: 3.0}),
    Work("embedded_frame", "a frame of `EmbeddedDeformation`, 500 nodes", "Gauss-Newton in SciPy, to 1 %",
         "space.embedded", (100_000,), {ANY: 20.0}),
    Work("cells_frame", "a frame of `RigidCells`, 2,000 cells", "a frame of `Arap`",
         "space.cells", (50_000,), {ANY: 1.0}, at_most=True),
    Work("rbf_frame", "a frame of `Rbf`, 1,000 centres", "SciPy's RBFInterpolator",
         "space.rbf", (1_000_000,)),
    Work("mls_frame", "a frame of `Mls`, 50 handles, rigid", "the paper's loop on one thread",
         "space.mls", (100_000,), {ANY: 8.0}),
    Work("ffd_frame", "`Ffd.warp`, cubic lattice of 4 x 4 x 4", "NumPy's product of its weights",
         "space.ffd", (100_000, 1_000_000)),
    Work("wires_frame", "a frame of `Wires`, 3 wires", "a vectorised loop in NumPy",
         "space.wires", (100_000,), {100_000: (5.0, 10.0)}),
    Work("mean_value", "`MeanValue.bind`", "the loop of the paper, one thread",
         "cages.mean_value", (10_000, 100_000), {ANY: (7.0, 20.0)}),
    Work("green", "`Green.bind`", "the loop of the paper, one thread",
         "cages.green", (10_000, 100_000), {ANY: 50.0}),
    Work("green_quads", "`Green.bind`, `faces='quads'`, points near the cage", "the same cage as triangles",
         "cages.green_quads", (10_000, 100_000), {ANY: 6.0}, at_most=True),
    Work("harmonic", "`Harmonic.bind`, 10,000 points", "Mesh Deform, precision 5",
         "cages.harmonic", (10_000,)),
    Work("harmonic_error", "largest error of `Harmonic` weights", "Mesh Deform, precision 5",
         "cages.harmonic", (10_000,)),
    Work("frame_thin_shell", "a frame in Blender, `thin_shell`", "Laplacian Deform",
         "blender.frames", (100_000,), {ANY: 20.0}),
    Work("frame_arap", "a frame in Blender, `arap`", "Laplacian Deform, repeat 3",
         "blender.frames", (100_000,)),
    Work("drag_arap", "a frame of a drag in Blender, `arap`", "Laplacian Deform, repeat 3",
         "blender.frames", (100_000,), {ANY: 8.0}),
    Work("frame_cage", "a frame in Blender, `mean_value`, 296 cage vertices", "Mesh Deform",
         "blender.frames", (100_000,), {ANY: 1.0}),
    Work("first_thin_shell", "bind and first frame in Blender, `thin_shell`", "the bind of Laplacian Deform",
         "blender.frames", (100_000,), {ANY: 10.0}),
    Work("rebind_handle", "adding a handle in Blender, `thin_shell`", "a new bind",
         "blender.frames", (100_000,), {ANY: 2.0}),
    Work("frame_subdivision", "a frame of *Fast Subdivision*, less `refine`", "its bare write",
         "blender.frames", (100_000,), {ANY: 1.3}, at_most=True),
    Work("windows", "the module for Windows, under Wine", "the same on Linux",
         "windows.library", (50_000,), {ANY: 1.3}, at_most=True),
)  # fmt: skip
COUNTS = (
    Work("convergence", "the energy of `Arap` above its least", "",
         "counts.convergence", (2_000, 10_000, 40_000, 50_000, 200_000)),
    Work("settled", "iterations until a shape is close to its limit", "",
         "counts.settled", (10_000, 50_000, 100_000, 200_000)),
)  # fmt: skip
BY_ID = {work.id: work for work in (*WORKS, *COUNTS)}
