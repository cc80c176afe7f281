# SPDX-License-Identifier: GPL-3.0-or-later
"""The energy of Primo in NumPy, and its minimum: an oracle of tests.

Nothing here knows the four orthogonal parts of a gap, or centres of gravity of joints: a prism has eight or
more corners, and the gaps between them are weighted as the paper says.
"""

import numpy as np
import scipy.sparse as sparse

from ..meshes import carried, nearest_rotations
from .rows import Rows, crosses, differences

ANCHOR = 10.0  # of a held corner of a free prism, in medians of the weights
# (1/9) 2^(-|i-k| - |j-l|) for the corners (i, j) and (k, l) of a side: (0, 0), (0, 1), (1, 0), (1, 1)
CORNERS = np.array([(0, 0), (0, 1), (1, 0), (1, 1)])
MASS = 2.0 ** -np.abs(CORNERS[:, None] - CORNERS[None]).sum(-1) / 9.0


class Prisms(Rows):
    """The prisms of a mesh of faces with equally many corners, without a degenerate one, on a manifold.

    Their centres are the points of the rows: a row is a gap between two prisms, or one to a held vertex.
    """

    def __init__(self, points, faces, handles: list[np.ndarray], poses: np.ndarray, height: float) -> None:
        self.points, self.faces, self.centres = points, faces, points[faces].mean(1)
        following, spokes = np.roll(faces, -1, 1), points[faces] - self.centres[:, None]
        area = 0.5 * np.cross(spokes, np.roll(spokes, -1, axis=1)).sum(1)
        normals = np.zeros_like(points)
        np.add.at(normals, faces, area[:, None])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        hand = np.full(len(points), -1)
        for h, vertices in enumerate(handles):
            hand[vertices] = h
        held = (hand[faces] >= 0).all(1)
        self.free = np.flatnonzero(~held)

        ends = np.sort(np.stack([faces, following], -1).reshape(-1, 2), 1)
        owner = np.repeat(np.arange(len(faces)), faces.shape[1])
        order = np.lexsort(ends.T)
        ends, owner = ends[order], owner[order]
        first = np.flatnonzero((ends[:-1] == ends[1:]).all(1))
        a, b, edge = owner[first], owner[first + 1], ends[first]
        sizes = np.linalg.norm(area, axis=1)
        weights = 2 * ((points[edge[:, 0]] - points[edge[:, 1]]) ** 2).sum(1) / (sizes[a] + sizes[b])
        typical, both = np.median(weights), ~(held[a] & held[b])
        a, b, edge, weights = a[both], b[both], edge[both], weights[both]
        up = height * normals[edge]
        corners = np.stack([points[edge] - up, points[edge] + up], 2).reshape(-1, 4, 3)
        face, corner = np.nonzero((hand[faces] >= 0) & ~held[:, None])
        vertex = faces[face, corner]

        C = np.linalg.cholesky(MASS).T  # takes gaps of corners to rows whose squares add up
        gaps = sparse.kron(differences(a, b, len(faces)), C.sum(1)[:, None])
        self.D = sparse.vstack([gaps, sparse.identity(len(faces), format="csr")[face]]).tocsr()
        self.weight = np.concatenate([np.repeat(weights, 4), np.full(len(face), ANCHOR * typical)])
        self.sides = []  # the prism of each row, and what it turns
        for prism, sign, own in ((a, -1.0, points[vertex] - self.centres[face]), (b, 1.0, 0.0)):
            arms = sign * np.einsum("cd,pdk->pck", C, corners - self.centres[prism][:, None]).reshape(-1, 3)
            whole = np.concatenate([arms, np.broadcast_to(-1.0 * np.asarray(own), (len(face), 3))])
            self.sides.append((np.concatenate([np.repeat(prism, 4), face]), whole))
        targets = carried(poses[hand[vertex]], points[vertex])
        self.fixed = np.concatenate([np.zeros((4 * len(a), 3)), targets])

        self.t, self.R = self.centres.copy(), np.tile(np.eye(3), (len(faces), 1, 1))
        own = poses[hand[faces[held, 0]]]
        self.t[held], self.R[held] = carried(own, self.centres[held]), own[:, :, :3]
        self.held_vertices = np.flatnonzero(hand >= 0)
        self.targets = carried(poses[hand[self.held_vertices]], points[self.held_vertices])

    def turned(self, R: np.ndarray) -> np.ndarray:
        return self.fixed + sum(np.einsum("kab,kb->ka", R[prism], u) for prism, u in self.sides)

    def slopes(self, R: np.ndarray) -> sparse.csr_matrix:
        return sum(crosses(np.einsum("kab,kb->ka", R[g], u), g, len(R)) for g, u in self.sides)

    def gauss_newton(self) -> float:
        """Joint steps of all prisms."""
        self.t, energy, self.R = self.minimum(self.t, self.free, self.R, self.free)
        return energy

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
