# SPDX-License-Identifier: GPL-3.0-or-later
"""The energy of Primo in NumPy, and its minimum: an oracle of tests.

Nothing here knows the four orthogonal parts of a gap, or centres of gravity of joints: a prism has eight or
more corners, and the gaps between them are weighted as the paper says.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve
from scipy.spatial.transform import Rotation

from ..meshes import carried, nearest_rotations

ANCHOR = 10.0  # of a held corner of a free prism, in medians of the weights
# (1/9) 2^(-|i-k| - |j-l|) for the corners (i, j) and (k, l) of a side: (0, 0), (0, 1), (1, 0), (1, 1)
CORNERS = np.array([(0, 0), (0, 1), (1, 0), (1, 1)])
MASS = 2.0 ** -np.abs(CORNERS[:, None] - CORNERS[None]).sum(-1) / 9.0


@dataclass
class Prisms:
    """The prisms of a mesh of faces with equally many corners, without a degenerate one, on a manifold."""

    points: np.ndarray  # (n, 3)
    faces: np.ndarray  # (m, k)
    handles: list[np.ndarray]
    poses: np.ndarray  # rigid
    height: float  # a length

    def __post_init__(self) -> None:
        points, faces = self.points, self.faces
        self.centres = points[faces].mean(1)
        following = np.roll(faces, -1, 1)
        spokes = points[faces] - self.centres[:, None]
        area = 0.5 * np.cross(spokes, np.roll(spokes, -1, axis=1)).sum(1)
        normals = np.zeros_like(points)
        np.add.at(normals, faces, area[:, None])
        normals /= np.linalg.norm(normals, axis=1)[:, None]

        ends = np.sort(np.stack([faces, following], -1).reshape(-1, 2), 1)
        owner = np.repeat(np.arange(len(faces)), faces.shape[1])
        order = np.lexsort(ends.T)
        ends, owner = ends[order], owner[order]
        first = np.flatnonzero((ends[:-1] == ends[1:]).all(1))
        self.pairs = np.stack([owner[first], owner[first + 1]], 1)
        edge = ends[first]
        sizes = np.linalg.norm(area, axis=1)
        length = np.linalg.norm(points[edge[:, 0]] - points[edge[:, 1]], axis=1)
        self.weights = 2 * length**2 / sizes[self.pairs].sum(1)
        self.typical = np.median(self.weights)
        up = self.height * normals[edge]
        self.corners = np.stack([points[edge] - up, points[edge] + up], 2).reshape(-1, 4, 3)

        hand = np.full(len(points), -1)
        for h, vertices in enumerate(self.handles):
            hand[vertices] = h
        self.held = (hand[faces] >= 0).all(1)
        self.free = np.flatnonzero(~self.held)
        both = ~self.held[self.pairs].all(1)
        self.pairs, self.weights, self.corners = self.pairs[both], self.weights[both], self.corners[both]
        face, corner = np.nonzero((hand[faces] >= 0) & ~self.held[:, None])
        vertex = faces[face, corner]
        self.anchored, self.anchors = face, points[vertex]
        self.anchor_targets = carried(self.poses[hand[vertex]], points[vertex])
        self.t = self.centres.copy()
        self.R = np.tile(np.eye(3), (len(faces), 1, 1))
        own = hand[faces[self.held, 0]]
        self.t[self.held] = carried(self.poses[own], self.centres[self.held])
        self.R[self.held] = self.poses[own][:, :, :3]
        self.held_vertices = np.flatnonzero(hand >= 0)
        self.targets = carried(self.poses[hand[self.held_vertices]], points[self.held_vertices])

    def _arms(self) -> tuple[np.ndarray, np.ndarray]:
        """R (corner - centre) for both prisms of each pair (pairs, 2, 4, 3), and for anchors (anchors, 3)."""
        rest = self.corners[:, None] - self.centres[self.pairs][:, :, None]
        arms = np.einsum("psij,pscj->psci", self.R[self.pairs], rest)
        own = np.einsum("kij,kj->ki", self.R[self.anchored], self.anchors - self.centres[self.anchored])
        return arms, own

    def residual(self) -> np.ndarray:
        """Half its square is the energy."""
        arms, own = self._arms()
        images = self.t[self.pairs][:, :, None] + arms
        gaps = np.einsum("cd,pdk->pck", np.linalg.cholesky(MASS).T, images[:, 0] - images[:, 1])
        pulls = self.t[self.anchored] + own - self.anchor_targets
        gaps = np.sqrt(self.weights)[:, None, None] * gaps
        return np.concatenate([gaps.ravel(), np.sqrt(ANCHOR * self.typical) * pulls.ravel()])

    def energy(self) -> float:
        return 0.5 * float(self.residual() @ self.residual())

    def jacobian(self) -> sp.csr_matrix:
        """Of the residual, by the translations and turns of the free prisms, six columns each."""
        arms, own = self._arms()
        C, count, corners = np.linalg.cholesky(MASS).T, len(self.pairs), 4 * len(self.pairs)
        parts = []  # (k, 3, 6) blocks, and the bodies that they are of, by rows of three
        for side, sign in ((0, 1.0), (1, -1.0)):
            arm = np.einsum("cd,pdk->pck", C, arms[:, side]).reshape(-1, 3)
            unit = np.tile(C.sum(1), count)[:, None, None] * np.eye(3)
            root = np.repeat(sign * np.sqrt(self.weights), 4)[:, None, None]
            blocks = root * np.concatenate([unit, np.cross(arm[:, None], np.eye(3))], 2)
            parts.append((blocks, np.repeat(self.pairs[:, side], 4), np.arange(corners)))
        unit = np.broadcast_to(np.eye(3), (len(own), 3, 3))
        blocks = np.sqrt(ANCHOR * self.typical) * np.concatenate([unit, np.cross(own[:, None], np.eye(3))], 2)
        parts.append((blocks, self.anchored, corners + np.arange(len(own))))
        blocks, bodies, rows = (np.concatenate(part) for part in zip(*parts))
        place = np.cumsum(~self.held) - 1
        inside = ~self.held[bodies]
        rows = 3 * rows[inside, None, None] + np.arange(3)[:, None] + np.zeros(6, int)
        columns = 6 * place[bodies[inside], None, None] + np.zeros((3, 1), int) + np.arange(6)
        shape = 3 * (corners + len(own)), 6 * len(self.free)
        return sp.csr_matrix((blocks[inside].ravel(), (rows.ravel(), columns.ravel())), shape=shape)

    def gauss_newton(self, steps: int = 40, tolerance: float = 1e-12) -> float:
        """Joint steps of all prisms, halved until the energy falls."""
        for _ in range(steps):
            J, r = self.jacobian(), self.residual()
            H = (J.T @ J).tocsc()
            gradient = J.T @ r
            step = -spsolve(H + 1e-10 * H.diagonal().mean() * sp.identity(H.shape[0], format="csc"), gradient)
            d = step.reshape(-1, 6)
            before, t, R = 0.5 * float(r @ r), self.t.copy(), self.R.copy()
            for length in 0.5 ** np.arange(14):
                self.t[self.free] = t[self.free] + length * d[:, :3]
                self.R[self.free] = Rotation.from_rotvec(length * d[:, 3:]).as_matrix() @ R[self.free]
                if self.energy() <= before + 1e-4 * length * float(gradient @ step):
                    break
            else:
                self.t, self.R = t, R
                break
            if before - self.energy() <= tolerance * before:
                break
        return self.energy()

    def vertices(self) -> np.ndarray:
        """(n, 3) the mean of what the prisms around each vertex say; held vertices at their targets."""
        arms = self.points[self.faces] - self.centres[:, None]
        images = self.t[:, None] + np.einsum("fij,fkj->fki", self.R, arms)
        sums, count = np.zeros_like(self.points), np.bincount(self.faces.ravel(), minlength=len(self.points))
        np.add.at(sums, self.faces, images)
        result = sums / count[:, None]
        result[self.held_vertices] = self.targets
        return result

    def start_from(self, positions: np.ndarray) -> None:
        """Free prisms where the vertices of another shape are."""
        f = self.faces[self.free]
        rest, now = self.points[f], positions[f]
        rest, now = rest - rest.mean(1, keepdims=True), now - now.mean(1, keepdims=True)
        S = np.einsum("fka,fkb->fab", now, rest)
        normal = np.cross(rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0])
        turned = np.cross(now[:, 1] - now[:, 0], now[:, 2] - now[:, 0])
        self.R[self.free] = nearest_rotations(S + turned[:, :, None] * normal[:, None, :])
        self.t[self.free] = positions[f].mean(1)
