# SPDX-License-Identifier: GPL-3.0-or-later
"""What is measured, the peer that it is compared with, and the ratio that is wanted."""

from collections.abc import Mapping
from dataclasses import dataclass

from record import Row

CONVERGENCE_BUDGETS = (0, 4, 10, 20, 40)  # iterations after which the excess energy is reported
ANY = 0  # the size that stands for all other sizes
# Nominal vertices -> ratio, or ratios on one and two threads.
Wanted = Mapping[int, float | tuple[float, float]]


@dataclass(frozen=True)
class Work:
    """A row of the table. Stored results name its ``id``; ``what`` and ``peer`` are for readers."""

    id: str
    what: str
    peer: str
    wanted: Wanted
    # The difference between two equal measurements, for a work that only has to be no slower.
    noise: float = 0.0
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
        return self.ratio(row) <= goal if self.at_most else self.ratio(row) >= goal - self.noise


FRAME = "Laplacian Deform"
LINUX = "the same on Linux"
WORKS = (
    Work("bind", "binding `ThinShell`", "CHOLMOD's supernodal factor", {ANY: 1.0, 500_000: 1.2}),
    Work("bind_peak", "peak memory of binding `ThinShell`", "CHOLMOD's", {ANY: 1.0}, at_most=True),
    Work("bind_ldlt", "binding `ThinShell`", "Eigen's LDLT factor", {50_000: 3.0, 200_000: 8.0}),
    Work("memory", "memory of a bound `ThinShell`", "CHOLMOD's factor alone", {500_000: 1.5}, at_most=True),
    Work("solve", "`ThinShell.solve`", "CHOLMOD's solve", {50_000: 1.5, 200_000: 1.5}),
    Work(
        "solve_bound",
        "`ThinShell.solve`",
        "reading its factor from memory twice",
        {50_000: 2.5, 200_000: 2.5},
        at_most=True,
    ),
    Work(
        "basis_bound",
        "`ThinShell.solve` by an affine basis, 4 handles",
        "reading and writing its arrays once",
        {ANY: 0.5},
    ),
    Work(
        "handle_added", "adding a handle of 100 vertices to a bound `ThinShell`", "a new bind", {100_000: 2.0}
    ),
    Work(
        "stiffness_painted",
        "painting 100 vertices of the stiffness of a bound `ThinShell`",
        "a new bind",
        {100_000: 2.0},
    ),
    Work("linear_bind", "binding a linear surface method", "binding `ThinShell`", {ANY: 3.0}, at_most=True),
    Work(
        "linear_frame",
        "a frame of a linear surface method",
        "`ThinShell.solve` without its basis",
        {ANY: 1.3},
        at_most=True,
    ),
    Work(
        "propagation_bound",
        "a frame of `Propagation`",
        "reading and writing its arrays once",
        {ANY: 0.5},
    ),
    Work(
        "hierarchical_frame",
        "a frame of `HierarchicalSmoothing`",
        "`ThinShell.solve` without its basis",
        {ANY: 3.0},
        at_most=True,
    ),
    Work(
        "volumetric_bind",
        "binding `VolumetricGraphLaplacian`",
        "binding `ThinShell`",
        {ANY: 15.0},
        at_most=True,
    ),
    Work(
        "volumetric_frame",
        "a frame of `VolumetricGraphLaplacian`",
        "`ThinShell.solve` without its basis",
        {ANY: 8.0},
        at_most=True,
    ),
    Work("rbf_bind", "binding `Rbf`, 1,000 centres", "SciPy's RBFInterpolator", {ANY: 5.0}),
    Work(
        "rbf_evaluate", "a frame of `Rbf` at 1,000,000 points, 1,000 centres", "RBFInterpolator", {ANY: 20.0}
    ),
    Work(
        "rbf_compact_bind",
        "binding `Rbf`, a compact kernel that reaches 20 centres",
        "SciPy's k-d tree and SuperLU",
        {1000: 1.0, 3000: 2.5, 10_000: 8.0},
    ),
    Work("rbf_compact_frame", "a frame of such an `Rbf`", "SciPy's k-d tree", {ANY: (10.0, 20.0)}),
    Work(
        "rbf_compact_all",
        "a frame of such an `Rbf`",
        "a kernel that reaches all centres",
        {1000: 2.0, 3000: 5.0, 10_000: 15.0},
    ),
    Work("rbf_basis", "a frame of `Rbf`, 4 handles of many points", "30 million points a second", {ANY: 1.0}),
    Work(
        "rbf_incremental",
        "binding `Rbf` to 1e-3, 10,000 handle points",
        "LAPACK's solve of the dense system",
        {ANY: 10.0},
    ),
    Work(
        "rbf_incremental_error",
        "how far handle points are from their targets then",
        "the bound",
        {ANY: 1.0},
        at_most=True,
    ),
    Work("mls_frame", "a frame of `Mls`, 50 handles, rigid", "the paper's loop on one thread", {ANY: 8.0}),
    Work(
        "subdivision_editing_frame",
        "a frame of `SubdivisionEditing`",
        "`ThinShell.solve` without its basis",
        {ANY: 1.3},
        at_most=True,
    ),
    Work(
        "isolines_frame",
        "a frame of `HandleAwareIsolines`, 24 bands",
        "the wanted 10 ms",
        {100_000: 1.0},
        at_most=True,
    ),
    Work(
        "isolines_iterations",
        "turns of `HandleAwareIsolines` to 1 % of its converged shape",
        "12",
        {},
        at_most=True,
    ),
    Work(
        "subspace_frame",
        "a frame of `SubspaceLaplacian` with the volume",
        "the wanted 20 ms",
        {100_000: 1.0},
        at_most=True,
    ),
    Work(
        "subspace_iterations",
        "iterations of `SubspaceLaplacian` to 1 % of its converged shape",
        "the wanted 12",
        {ANY: 1.0},
        at_most=True,
    ),
    Work(
        "multiresolution_displacement_vectors",
        "a frame of `Multiresolution` with displacement vectors",
        "`ThinShell.solve` of its base",
        {ANY: 1.3},
        at_most=True,
    ),
    Work(
        "multiresolution_normal_displacements",
        "a frame of `Multiresolution` with normal displacements",
        "`ThinShell.solve` of its base",
        {ANY: 1.5},
        at_most=True,
    ),
    Work(
        "multiresolution_deformation_transfer",
        "a frame of `Multiresolution` with deformation transfer",
        "`ThinShell.solve` of its base",
        {ANY: 2.0},
        at_most=True,
    ),
    Work(
        "multiresolution_displacement_volumes",
        "a frame of `Multiresolution` with displacement volumes",
        "`ThinShell.solve` of its base",
        {ANY: 10.0},
        at_most=True,
    ),
    Work(
        "multiresolution_bind_displacement_vectors",
        "a bind of `Multiresolution` with displacement vectors",
        "`ThinShell.set_handles` of its base",
        {ANY: 2.2},
        at_most=True,
    ),
    Work(
        "multiresolution_bind_normal_displacements",
        "a bind of `Multiresolution` with normal displacements",
        "`ThinShell.set_handles` of its base",
        {ANY: 2.3},
        at_most=True,
    ),
    Work(
        "multiresolution_bind_deformation_transfer",
        "a bind of `Multiresolution` with deformation transfer",
        "`ThinShell.set_handles` of its base",
        {ANY: 2.6},
        at_most=True,
    ),
    Work(
        "multiresolution_bind_displacement_volumes",
        "a bind of `Multiresolution` with displacement volumes",
        "`ThinShell.set_handles` of its base",
        {ANY: 3.5},
        at_most=True,
    ),
    Work(
        "none_frame",
        "a frame of `LaplacianEditing` without transformations",
        "`ThinShell.solve` without its basis",
        {ANY: 1.0},
        at_most=True,
    ),
    Work(
        "explicit_frame",
        "a frame of `LaplacianEditing` with transformations from handles",
        "`ThinShell.solve` without its basis",
        {ANY: 1.7},
        at_most=True,
    ),
    Work(
        "estimated_frame",
        "a frame of `LaplacianEditing` with two refits",
        "`ThinShell.solve` without its basis",
        {ANY: 3.9},
        at_most=True,
    ),
    Work(
        "implicit_bind",
        "binding `LaplacianEditing` with implicit transformations",
        "binding `ThinShell`",
        {ANY: 20.0},
        at_most=True,
    ),
    Work(
        "implicit_frame",
        "a frame of `LaplacianEditing` with implicit transformations",
        "`ThinShell.solve` without its basis",
        {ANY: 3.0},
        at_most=True,
    ),
    Work(
        "attachments_bind",
        "binding loose parts that follow, 20 shells or 200 loose vertices per 1,000 vertices",
        "a limit of 1 s",
        {ANY: 1.0},
    ),
    Work("puppet_iteration", "an iteration of `Skeleton.solve`", "a millisecond", {ANY: 1.0}, at_most=True),
    Work("puppet_pose", "the slowest of 30 poses by `Skeleton.solve`", "30 ms", {ANY: 1.0}, at_most=True),
    Work("puppet_peer", "a pose by `Skeleton.solve`", "SciPy's least squares", {ANY: 20.0}),
    Work("attachments_frame", "what these loose parts add to a solve", "the solve", {ANY: 0.1}, at_most=True),
    Work(
        "arap_iteration",
        "one iteration of `Arap`, spokes and rims",
        "libigl",
        {10_000: (8.0, 12.0), 50_000: (8.0, 12.0), 200_000: (7.0, 11.0)},
    ),
    Work(
        "arap_spokes",
        "one iteration of `Arap`, spokes",
        "libigl",
        {10_000: (8.0, 12.0), 50_000: (8.0, 12.0), 200_000: (7.0, 11.0)},
    ),
    Work(
        "arap_smooth",
        "one iteration of `Arap` with smooth rotations",
        "one without",
        {ANY: 1.6},
        at_most=True,
    ),
    Work(
        "arap_bend", "`Arap` to 1 % above its least energy, bar bent by 90 degrees", "libigl", {50_000: 50.0}
    ),
    Work(
        "shell_iteration",
        "one iteration of `ThinShellNonlinear`",
        "one of `Arap`, spokes",
        {ANY: 3.0},
        at_most=True,
    ),
    Work("shell_frame", "a frame of `ThinShellNonlinear`", "150 ms", {50_000: 1.0}, at_most=True),
    Work(
        "shell_joint",
        "`ThinShellNonlinear` to its least energy",
        "Gauss-Newton with CHOLMOD",
        {10_000: 20.0},
    ),
    Work(
        "arap_cold",
        "`Arap` to 1 % above its least energy, armadillo",
        "4 iterations of libigl",
        {ANY: 1.0},
    ),
    Work(
        "pyramid_iteration",
        "one iteration of `PyramidCoordinates`",
        "one of `Arap`, spokes",
        {ANY: 1.5},
        at_most=True,
    ),
    Work(
        "pyramid_frame",
        "a frame of `PyramidCoordinates`, bar bent by 90 degrees",
        "100 ms",
        {50_000: 1.0},
        at_most=True,
    ),
    Work(
        "pyramid_settled",
        "iterations of `PyramidCoordinates` to 1 % of the way, bars bent and twisted",
        "15 iterations",
        {ANY: 1.0},
        at_most=True,
    ),
    Work(
        "primo_iteration",
        "one iteration of `Primo`",
        "one of `Arap` with smooth rotations",
        {ANY: 2.5},
        at_most=True,
    ),
    Work("primo_steps", "iterations of `Primo` to 1 % of its limit", "1", {ANY: 4.0}, at_most=True),
    Work("primo_frame", "a frame of `Primo`", "a limit of 150 ms", {50_000: 1.0}, at_most=True),
    Work("primo_joint", "one iteration of `Primo`", "a joint Gauss-Newton step", {10_000: 20.0}),
    Work(
        "embedded_frame",
        "a frame of `EmbeddedDeformation`, 500 nodes",
        "Gauss-Newton in SciPy, to 1 %",
        {100_000: 20.0},
    ),
    Work("embedded_drag", "the same", "a limit of 20 ms", {100_000: 1.0}, at_most=True),
    Work("embedded_steps", "its iterations", "steps of Gauss-Newton to 1 %", {}, at_most=True),
    Work(
        "cells_frame",
        "a frame of `RigidCells`, 2,000 cells",
        "a frame of `Arap`",
        {50_000: 1.0},
        at_most=True,
    ),
    Work("primo_matching", "one iteration of `Primo`", "a sweep of shape matching in NumPy", {}),
    Work(
        "subdivision",
        "`SubdivisionSurface.refine`, a million vertices",
        "OpenSubdiv's CPU evaluator",
        {ANY: 3.0},
    ),
    Work(
        "subdivision_blender",
        "`SubdivisionSurface.refine`, a million vertices",
        "a frame of Blender's Subdivision modifier",
        {ANY: 4.0},
    ),
    Work(
        "subdivision_frame",
        "`SubdivisionSurface.refine`, written to and evaluated by Blender",
        "a frame of Blender's Subdivision modifier",
        {ANY: 1.0},
    ),
    Work("cage_time", "`automatic_cage` around a scan, 300 faces", "a limit of two seconds", {ANY: 1.0}),
    Work(
        "cage_poking",
        "faces of the scan that cross its automatic cage",
        "a cage by Blender's remesh, displace and decimate",
        {ANY: 0.0},
        at_most=True,
    ),
    Work("mean_value_double", "`MeanValue.bind`, double precision", "the loop of the paper", {ANY: 7.0}),
    Work("mean_value", "`MeanValue.bind`", "the loop of the paper, one thread", {ANY: (7.0, 20.0)}),
    Work("green", "`Green.bind`", "the loop of the paper, one thread", {ANY: 50.0}),
    Work(
        "green_quads",
        "`Green.bind`, `faces='quads'`, points near the cage",
        "the same cage as triangles",
        {ANY: 6.0},
        at_most=True,
    ),
    Work(
        "green_quads_frame",
        "`warp` of `Green`, `faces='quads'`",
        "the same cage as triangles",
        {ANY: 1.1},
        at_most=True,
    ),
    Work("cage_warp", "`warp` of a cage, single precision", "BLAS `sgemm`, one thread", {ANY: 1.5}),
    Work("wires_bind", "binding `Wires`, 3 wires", "a vectorised loop in NumPy", {}),
    Work("wires_frame", "a frame of `Wires`, 3 wires", "a vectorised loop in NumPy", {100_000: (5.0, 10.0)}),
    Work(
        "field_frame",
        "a frame of `VectorField`, 100 steps",
        "SciPy's `RK45` with as many, vectorised",
        {100_000: (10.0, 20.0)},
    ),
    Work(
        "overhead_wires",
        "a frame in Blender without its warp, 3 wires",
        "writing and evaluating a shape alone",
        {ANY: 1.3},
        at_most=True,
    ),
    Work(
        "overhead_field",
        "a frame in Blender without its warp, a tool of `vector_field`",
        "writing and evaluating a shape alone",
        {ANY: 1.3},
        at_most=True,
    ),
    Work(
        "sequence_frame",
        "a frame of `MeshSequence`",
        "`Arap.solve` for the same poses",
        {ANY: 1.05},
        at_most=True,
    ),
    Work(
        "sequence_at_once",
        "16 frames of `MeshSequence` at once",
        "the same one by one",
        {ANY: (1.0, 1.1)},
        noise=0.05,
    ),
    Work(
        "sequence_threads",
        "16 frames of `MeshSequence` at once, on two threads",
        "the same on one thread",
        {ANY: 1.6},
    ),
    Work("frame_thin_shell", "a frame in Blender, `thin_shell`", FRAME, {ANY: 20.0}),
    Work("frame_laplacian_editing", "a frame in Blender, `laplacian_editing`", FRAME, {ANY: 10.0}),
    Work(
        "frame_laplacian_explicit",
        "a frame in Blender, `laplacian_editing` with transformations from handles",
        FRAME,
        {ANY: 10.0},
    ),
    Work("frame_arap", "a frame in Blender, `arap`", f"{FRAME}, repeat 3", {ANY: 8.0}),
    Work("frame_arap_3", "a frame in Blender, `arap` with 3 iterations", f"{FRAME}, repeat 3", {ANY: 8.0}),
    Work(
        "frame_arap_draft",
        "a frame in Blender, `arap` as a draft in playback",
        f"{FRAME}, repeat 3",
        {ANY: 8.0},
    ),
    Work("frame_cage", "a frame in Blender, `mean_value`, 296 cage vertices", "Mesh Deform", {ANY: 1.0}),
    Work(
        "ffd_frame",
        "`Ffd.warp` of a frame in Blender, cubic lattice of 4 x 4 x 4, a million vertices",
        "Blender's Lattice modifier",
        {ANY: 3.0},
    ),
    Work(
        "overhead_ffd",
        "a frame in Blender without its solve, `ffd`, a million vertices",
        "writing and evaluating a shape alone",
        {ANY: 1.3},
        at_most=True,
    ),
    Work("ffd_bind", "binding `Ffd` to a lattice of equal cells", "a second per million points", {ANY: 1.0}),
    Work("ffd_warp", "`Ffd.warp`, cubic lattice of 4 x 4 x 4", "NumPy's product of its weights", {ANY: 3.0}),
    Work("drag_arap", "a frame of a drag in Blender, `arap`", f"{FRAME}, repeat 3", {ANY: 8.0}),
    Work(
        "overhead_thin_shell",
        "a frame in Blender without its solve, `thin_shell`",
        "writing and evaluating a shape alone",
        {ANY: 1.2},
        at_most=True,
    ),
    Work(
        "overhead_arap",
        "a frame of a drag in Blender without its solve, `arap`",
        "writing and evaluating a shape alone",
        {ANY: 1.2},
        at_most=True,
    ),
    Work(
        "first_thin_shell",
        "bind and first frame in Blender, `thin_shell`",
        f"the bind of {FRAME}",
        {ANY: 10.0},
    ),
    Work("first_arap", "bind and first frame in Blender, `arap`", f"the bind of {FRAME}", {ANY: 10.0}),
    Work(
        "reading_thin_shell",
        "reading a mesh of a million vertices, `thin_shell`",
        "the whole bind",
        {ANY: 0.1},
        at_most=True,
    ),
    Work(
        "reading_arap",
        "reading a mesh of a million vertices, `arap`",
        "the whole bind",
        {ANY: 0.1},
        at_most=True,
    ),
    Work("rebind_handle", "adding a handle in Blender, `thin_shell`", "a new bind", {ANY: 2.0}),
    Work("rebind_stiffness", "painting stiffness in Blender, `thin_shell`", "a new bind", {ANY: 2.0}),
    Work("harmonic_5", "`Harmonic.bind`, 10,000 points", "Mesh Deform, precision 5", {ANY: 10.0}),
    Work("harmonic_error_5", "largest error of `Harmonic` weights", "Mesh Deform, precision 5", {ANY: 10.0}),
    Work("harmonic_6", "`Harmonic.bind`, 10,000 points", "Mesh Deform, precision 6", {ANY: 100.0}),
    Work("harmonic_error_6", "largest error of `Harmonic` weights", "Mesh Deform, precision 6", {ANY: 10.0}),
    Work("harmonic_large", "`Harmonic.bind` by a lattice, 10,000 points", "boundary elements", {ANY: 1.0}),
    Work(
        "harmonic_large_peak",
        "peak memory of `Harmonic.bind` by a lattice",
        "boundary elements",
        {ANY: 1.0},
        at_most=True,
    ),
    Work("positive_rays", "exact `PositiveMeanValue.bind`, 300 faces", "4,096 rays per point", {ANY: 1.0}),
    Work(
        "positive_point",
        "time per point of exact `PositiveMeanValue.bind`",
        "a limit of 200 microseconds",
        {ANY: 1.0},
    ),
    Work(
        "positive_error",
        "error of exact positive mean values, against 8 million rays",
        "error of 4,096 rays",
        {ANY: 100.0},
    ),
    Work("windows_bind", "a bind by the module for Windows, under Wine", LINUX, {ANY: 1.3}, at_most=True),
    Work(
        "windows_solve",
        "a solve or warp by the module for Windows, under Wine",
        LINUX,
        {ANY: 1.3},
        at_most=True,
    ),
    Work("windows_frame", "a frame in Windows' Blender 4.5, under Wine", LINUX, {ANY: 1.3}, at_most=True),
    Work("two_threads", "two threads", "one thread", {ANY: 1.0}, noise=0.03),
)
BY_ID = {work.id: work for work in WORKS}
# Works that time a loop of Sinew: on these, two threads must not be slower, and their growth is fitted.
OWN_TIMES = {
    "bind": "bind",
    "solve": "solve",
    "basis_bound": "affine basis",
    "arap_iteration": "iteration of `Arap`, spokes and rims",
    "arap_spokes": "iteration of `Arap`, spokes",
    "arap_smooth": "iteration of `Arap`, smooth rotations",
    "arap_bend": "`Arap`, bend to 1 %",
    "arap_cold": "`Arap`, armadillo to 1 %",
    "shell_iteration": "iteration of `ThinShellNonlinear`",
    "subdivision": "subdivision",
    "handle_added": "adding a handle",
    "stiffness_painted": "painting stiffness",
}


def two_thread_rows(rows: list[Row]) -> list[Row]:
    """One row per work and size that was measured on one and on two threads; the peer is the time on one."""
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
