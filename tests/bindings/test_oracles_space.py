# SPDX-License-Identifier: GPL-3.0-or-later
"""Nonlinear space methods against oracles that share no code with them."""

from __future__ import annotations

import numpy as np
import pytest

import sinew_native as sn

scipy_sparse = pytest.importorskip("scipy.sparse")
spsolve = pytest.importorskip("scipy.sparse.linalg").spsolve

WEIGHTS = {"rotation": 1.0, "regularity": 10.0, "pulls": 100.0}
EDGE = [(a, b) for a in range(3) for b in range(a, 3)]


def tube(around: int = 12, along: int = 30) -> tuple[np.ndarray, np.ndarray]:
    """An open tube of length 6 and radius 1: points, and quads."""
    turn, height = np.meshgrid(
        np.linspace(0, 2 * np.pi, around, endpoint=False), np.linspace(0, 6, along), indexing="ij"
    )
    points = np.stack((np.cos(turn), np.sin(turn), height), -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(around), np.arange(along - 1), indexing="ij")
    k = (i + 1) % around
    quads = np.stack((i * along + j, k * along + j, k * along + j + 1, i * along + j + 1), -1)
    return points, quads.reshape(-1, 4)


def turned(axis: tuple, degrees: float, move: tuple = (0, 0, 0)) -> np.ndarray:
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    K = np.array([(0, -z, y), (z, 0, -x), (-y, x, 0)])
    angle = np.radians(degrees)
    R = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    return np.column_stack((R, move))


STILL = np.eye(4)[:3]
POSES = {
    "bend": np.stack((STILL, turned((0, 1, 0), 90, (0.5, 0, -3.5)))),
    "twist": np.stack((STILL, turned((0, 0, 1), 135))),
    "stretch": np.stack((STILL, turned((0, 0, 1), 0, (0, 0, 2)))),
}


class PaperEnergy:
    """The residuals of Sumner, Schmid & Pauly 2007 over A_j and t_j, in mean edges, and their derivatives."""

    def __init__(self, graph: dict, targets: np.ndarray) -> None:
        self.unit = graph["edge_length"]
        self.nodes, self.targets = graph["nodes"] / self.unit, targets / self.unit
        pulls = graph["pulls"] / self.unit
        m = len(self.nodes)
        rows, columns, values = [], [], []

        def field(row: int, at: np.ndarray, j: int, weight: float) -> None:
            """weight (A_j (at - g_j) + t_j), whose three coordinates are rows of one matrix each."""
            rows.extend([row] * 4)
            columns.extend(range(4 * j, 4 * j + 4))
            values.extend(weight * np.append(at - self.nodes[j], 1.0))

        self.right, row = [], 0
        for a, b in graph["edges"]:
            for j, k in ((a, b), (b, a)):
                root = np.sqrt(WEIGHTS["regularity"])
                field(row, self.nodes[k], j, root)
                rows.append(row)
                columns.append(4 * k + 3)
                values.append(-root)
                self.right.append(root * (self.nodes[k] - self.nodes[j]))
                row += 1
        for p in range(len(pulls)):
            root = np.sqrt(WEIGHTS["pulls"] * graph["strengths"][p])
            wanted = self.targets[p].copy()
            for j in np.flatnonzero(graph["pull_weights"][p]):
                weight = graph["pull_weights"][p, j]
                field(row, pulls[p], j, root * weight)
                wanted -= weight * self.nodes[j]
            self.right.append(root * wanted)
            row += 1
        self.linear = scipy_sparse.csr_matrix((values, (rows, columns)), (row, 4 * m))
        self.right = np.array(self.right)

    def start(self) -> np.ndarray:
        x = np.zeros((len(self.nodes), 4, 3))
        x[:, :3] = np.eye(3)
        return x

    def rotations(self, x: np.ndarray) -> np.ndarray:
        A = x[:, :3].transpose(0, 2, 1)  # rows of x are the columns of A
        S = A.transpose(0, 2, 1) @ A - np.eye(3)
        return np.sqrt(WEIGHTS["rotation"]) * np.stack([S[:, a, b] for a, b in EDGE], 1)

    def residual(self, flat: np.ndarray) -> np.ndarray:
        x = flat.reshape(-1, 4, 3)
        linear = self.linear @ x.reshape(-1, 3) - self.right
        return np.concatenate((self.rotations(x).ravel(), linear.ravel()))

    def jacobian(self, flat: np.ndarray) -> scipy_sparse.csr_matrix:
        x = flat.reshape(-1, 4, 3)
        m, root = len(x), np.sqrt(WEIGHTS["rotation"])
        rows, columns, values = [], [], []
        for e, (a, b) in enumerate(EDGE):
            for own, other in ((a, b), (b, a)):
                rows.append(np.repeat(6 * np.arange(m) + e, 3))
                columns.append(((4 * np.arange(m) + own)[:, None] * 3 + np.arange(3)).ravel())
                values.append(root * x[:, other].ravel())
        quartic = scipy_sparse.csr_matrix(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (6 * m, 12 * m)
        )
        return scipy_sparse.vstack((quartic, scipy_sparse.kron(self.linear, scipy_sparse.eye(3)))).tocsr()

    def energy(self, flat: np.ndarray) -> float:
        return float(np.sum(self.residual(flat) ** 2))

    def gauss_newton(self, steps: int = 60) -> np.ndarray:
        flat = self.start().ravel()
        for _ in range(steps):
            J, r = self.jacobian(flat), self.residual(flat)
            step = spsolve((J.T @ J + 1e-9 * scipy_sparse.eye(len(flat))).tocsc(), J.T @ r)
            length = 1.0
            while self.energy(flat - length * step) > self.energy(flat) and length > 1e-6:
                length *= 0.5
            flat = flat - length * step
            if np.abs(step).max() < 1e-10:
                break
        return flat


@pytest.mark.parametrize("motion", POSES)
def test_embedded_deformation_has_the_minimum_of_gauss_newton_on_the_paper_s_energy(motion: str) -> None:
    points, faces = tube()
    ends = [np.flatnonzero(points[:, 2] < 0.5), np.flatnonzero(points[:, 2] > 5.5)]
    method = sn.EmbeddedDeformation(
        sn.SurfaceMesh(points, faces), points[np.concatenate(ends)], [len(end) for end in ends], nodes=40
    )
    method.bind(points)
    graph = method.graph()
    maps = POSES[motion][graph["pull_handles"]]
    targets = np.einsum("pij,pj->pi", maps[:, :, :3], graph["pulls"]) + maps[:, :, 3]
    oracle = PaperEnergy(graph, targets)
    least = oracle.gauss_newton()
    answer, report = method.answer(POSES[motion], tolerance=1e-13, max_iterations=2000)
    own = answer.reshape(-1, 4, 3).copy()
    own[:, 3] = own[:, 3] / oracle.unit - oracle.nodes  # t_j
    assert report.energy == pytest.approx(oracle.energy(own.ravel()), rel=1e-9), "the energy is the paper's"
    assert report.energy == pytest.approx(oracle.energy(least), rel=1e-8)
    found = least.reshape(-1, 4, 3)
    np.testing.assert_allclose(own, found, atol=1e-3 * np.ptp(oracle.nodes))

    quick = method.warp_poses(POSES[motion])
    weights, m = method.weights(), len(graph["nodes"])
    A = found[:, :3].transpose(0, 2, 1)
    by_nodes = np.einsum("ni,ixy,niy->nx", weights[:, :m], A, points[:, None] - graph["nodes"])
    by_nodes += weights[:, :m] @ (oracle.unit * (oracle.nodes + found[:, 3]))
    by_handles = np.zeros_like(points)
    for h, pose in enumerate(POSES[motion]):
        by_handles += weights[:, m + h, None] * (points @ pose[:, :3].T + pose[:, 3])
    moved = np.sqrt(np.mean((by_nodes + by_handles - points) ** 2))
    apart = np.sqrt(np.mean((quick - by_nodes - by_handles) ** 2))
    assert apart < 0.01 * moved, "a frame is within 1 %"


def test_rigid_cells_turn_a_beam_as_an_elastic_one() -> None:
    """A long bar twisted by its ends turns evenly along its length, as Saint-Venant's does."""
    points, faces = tube(along=61)
    points = points * (0.4, 0.4, 2.0)
    caps = np.stack([np.arange(12) * 61 + row for row in (0, 60)])
    counts = np.concatenate((np.full(len(faces), 4), [12, 12]))
    corners = np.concatenate((faces.ravel(), caps[0][::-1], caps[1]))
    ends = [np.flatnonzero(points[:, 2] < 1.0), np.flatnonzero(points[:, 2] > 11.0)]
    method = sn.RigidCells(
        sn.SurfaceMesh(points, (counts, corners)), points[np.concatenate(ends)], [len(end) for end in ends],
        cells=2000, tolerance=1e-7, max_iterations=400,
    )  # fmt: skip
    method.bind(points)
    shape = method.warp_poses(np.stack((STILL, turned((0, 0, 1), 90))))
    between = (points[:, 2] > 1.5) & (points[:, 2] < 10.5)
    angle = np.angle((shape[:, 0] + 1j * shape[:, 1]) / (points[:, 0] + 1j * points[:, 1]))
    np.testing.assert_allclose(angle[between], np.radians(90) * (points[between, 2] - 1.0) / 10.0, atol=0.05)
    np.testing.assert_allclose(shape[between, 2], points[between, 2], atol=0.05)
