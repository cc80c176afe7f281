# SPDX-License-Identifier: GPL-3.0-or-later
"""The energy of ``ThinShellNonlinear`` in NumPy, and Gauss-Newton on points and rotations together.

Written down from the header of the method, with no code of the library: the oracle of its tests. Each step
factorises a matrix of three unknowns per free vertex; those of the rotations are eliminated cell by cell
before. For manifold meshes of sound triangles.
"""

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu


def cross_matrices(v: np.ndarray) -> np.ndarray:
    """(..., 3, 3) the matrices that take the cross product with vectors from the left."""
    x, y, z = np.moveaxis(v, -1, 0)
    o = np.zeros_like(x)
    return np.stack([o, -z, y, z, o, -x, -y, x, o], -1).reshape(*v.shape, 3)


class JointShell:
    """The energy over free vertices, with its rotations."""

    def __init__(
        self, points: np.ndarray, faces: np.ndarray, held: np.ndarray, k_s: float, k_b: float
    ) -> None:
        self.points = points
        self.free = np.setdiff1d(np.arange(len(points)), held)
        sides: dict[tuple[int, int], list[tuple[int, int]]] = {}
        for t, face in enumerate(faces.tolist()):
            for k in range(3):
                a, b = face[(k + 1) % 3], face[(k + 2) % 3]
                sides.setdefault((min(a, b), max(a, b)), []).append((t, face[k]))
        pairs = [(edge, found) for edge, found in sides.items() if len(found) == 2]
        corners = np.array([(*edge, found[0][1], found[1][1]) for edge, found in pairs])
        triangles = np.array([[side[0] for side in found] for _edge, found in pairs])
        share = 1.0 / np.bincount(triangles.ravel(), minlength=len(faces))[triangles]

        p = points[corners]  # (m, 4, 3): both ends of the edge, then what lies opposite
        e = p[:, 1] - p[:, 0]
        areas, rows, weights, bend = [], [], [], np.zeros((len(corners), 4))
        for side in range(2):
            a, b, c = 0, 1, 2 + side
            area = 0.5 * np.linalg.norm(np.cross(e, p[:, c] - p[:, 0]), axis=1)
            areas.append(area)
            for i, j, k in ((a, b, c), (b, c, a), (c, a, b)):  # the edge (i, j) opposite k
                cotan = np.einsum("mi,mi->m", p[:, i] - p[:, k], p[:, j] - p[:, k]) / (2 * area)
                row = np.zeros((len(corners), 4))
                row[:, i], row[:, j] = 1.0, -1.0
                rows.append(row)
                weights.append(0.5 * k_s * share[:, side] * cotan)
                if k != c:  # this cotangent stands at an end of the hinge, at k
                    bend[:, b if k == a else a] += cotan
                    bend[:, c] -= cotan
        areas_of_both = areas[0] + areas[1]
        own = k_s * share.mean(1) * areas_of_both**2 / (4 * np.einsum("mi,mi->m", e, e))
        rows.append(bend)
        weights.append(np.maximum(k_b - own, 0.0) / areas_of_both)
        self.corners = corners
        self.rows = np.stack(rows, 1)  # (m, 7, 4)
        self.weights = np.stack(weights, 1)  # (m, 7)
        self.base = self.rows @ p  # (m, 7, 3)

    def rotations(self, q: np.ndarray) -> np.ndarray:
        S = np.einsum("mk,mki,mkj->mij", self.weights, self.rows @ q[self.corners], self.base)
        U, _, Vt = np.linalg.svd(S)
        U[:, :, 2] *= np.sign(np.linalg.det(U @ Vt))[:, None]
        return U @ Vt

    def residuals(self, q: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Those of the rows, and the base vectors after they have turned."""
        turned = np.einsum("mij,mkj->mki", R, self.base)
        return self.rows @ q[self.corners] - turned, turned

    def energy(self, q: np.ndarray) -> float:
        r, _ = self.residuals(q, self.rotations(q))
        return 0.5 * float(np.einsum("mk,mki,mki->", self.weights, r, r))

    def gradient(self, q: np.ndarray) -> np.ndarray:
        """(n, 3)"""
        r, _ = self.residuals(q, self.rotations(q))
        parts = np.einsum("mk,mkc,mki->mci", self.weights, self.rows, r)
        g = np.zeros_like(q)
        np.add.at(g, self.corners, parts)
        return g

    def hessian(self, q: np.ndarray) -> sparse.csc_matrix:
        """(3 f, 3 f) that of Gauss-Newton over the free points, the rotations eliminated."""
        _, turned = self.residuals(q, self.rotations(q))
        X = cross_matrices(turned)  # d r / d omega
        outer = np.einsum("mk,mkc,mkd->mcd", self.weights, self.rows, self.rows)
        K = np.einsum("mcd,ij->mcidj", outer, np.eye(3))
        B = np.einsum("mk,mkc,mkij->mcij", self.weights, self.rows, X).reshape(len(X), 12, 3)
        C = np.einsum("mk,mkji,mkjl->mil", self.weights, X, X)
        K = K.reshape(-1, 12, 12) - B @ np.linalg.inv(C) @ B.transpose(0, 2, 1)
        dofs = (3 * self.corners[:, :, None] + np.arange(3)).reshape(-1, 12)
        i, j = np.repeat(dofs, 12, 1).ravel(), np.tile(dofs, (1, 12)).ravel()
        n = 3 * len(self.points)
        A = sparse.coo_matrix((K.ravel(), (i, j)), (n, n)).tocsr()
        f = (3 * self.free[:, None] + np.arange(3)).ravel()
        return A[f][:, f].tocsc()

    def minimize(self, q: np.ndarray, most: int = 100, tolerance: float = 1e-12) -> tuple[np.ndarray, float]:
        """Damped steps with a test of the energy -> the points, and their energy."""
        energy, damping = self.energy(q), 1e-9
        for _ in range(most):
            H = self.hessian(q)
            H = H + damping * H.diagonal().mean() * sparse.identity(H.shape[0], format="csc")
            factor = splu(
                H.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.0
            )
            d = factor.solve(self.gradient(q)[self.free].ravel()).reshape(-1, 3)
            t = 1.0
            while t > 1e-4:
                trial = q.copy()
                trial[self.free] -= t * d
                if (reached := self.energy(trial)) < energy:
                    break
                t *= 0.5
            else:
                return q, energy
            done = energy - reached <= tolerance * energy
            q, energy = trial, reached
            if done:
                break
        return q, energy
