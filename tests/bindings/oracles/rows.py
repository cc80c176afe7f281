# SPDX-License-Identifier: GPL-3.0-or-later
"""Energies of rows in NumPy and SciPy, which most nonlinear surface methods have: the oracle of their tests.

Nothing here shares code with the library. The minimum is by Gauss-Newton on points and rotations together.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

from ..meshes import nearest_rotations


def differences(i: np.ndarray, j: np.ndarray, count: int) -> sparse.csr_matrix:
    """The matrix of x_i - x_j for pairs of ``count`` points."""
    one = sparse.identity(count, format="csr")
    return one[i] - one[j]


@dataclass
class Rows:
    """Half the sum of weight |D x - R_group u|^2, with a rotation for each group."""

    D: sparse.csr_matrix | np.ndarray  # (m, n)
    u: np.ndarray  # (m, 3)
    group: np.ndarray  # (m,)
    weight: np.ndarray  # (m,)

    def covariances(self, x: np.ndarray) -> np.ndarray:
        S = np.zeros((self.group.max() + 1, 3, 3))
        np.add.at(S, self.group, self.weight[:, None, None] * (self.D @ x)[:, :, None] * self.u[:, None, :])
        return S

    def rotations(self, x: np.ndarray) -> np.ndarray:
        """Those that make the energy least."""
        return nearest_rotations(self.covariances(x))

    def turned(self, R: np.ndarray) -> np.ndarray:
        return np.einsum("kab,kb->ka", R[self.group], self.u)

    def energy(self, x: np.ndarray, R: np.ndarray | None = None) -> float:
        gaps = self.D @ x - self.turned(self.rotations(x) if R is None else R)
        return 0.5 * float(self.weight @ (gaps**2).sum(1))

    def gradient(self, x: np.ndarray, R: np.ndarray | None = None) -> np.ndarray:
        """(n, 3)"""
        gaps = self.D @ x - self.turned(self.rotations(x) if R is None else R)
        return self.D.T @ (self.weight[:, None] * gaps)

    def minimum(self, x: np.ndarray, free: np.ndarray) -> tuple[np.ndarray, float]:
        """Over free points and all rotations, from a start: the points, and their energy."""
        root = sparse.diags(np.sqrt(np.repeat(self.weight, 3)))
        of_points = sparse.kron(self.D[:, free], sparse.identity(3), format="csr")
        R, m = self.rotations(x), len(self.u)
        rows = np.broadcast_to(3 * np.arange(m)[:, None, None] + np.arange(3)[:, None], (m, 3, 3)).ravel()
        columns = np.broadcast_to(3 * self.group[:, None, None] + np.arange(3), (m, 3, 3)).ravel()
        E = self.energy(x, R)
        for _ in range(200):
            turned = self.turned(R)
            cross = -np.cross(turned[:, None], np.eye(3))  # the matrices of turned x
            of_turns = sparse.csr_matrix((cross.ravel(), (rows, columns)), (3 * m, 3 * len(R)))
            J = root @ sparse.hstack([of_points, of_turns])
            A = (J.T @ J).tocsc()
            A += 1e-10 * A.diagonal().mean() * sparse.identity(A.shape[0])
            step = -splu(A.tocsc()).solve(J.T @ (root @ (self.D @ x - turned).ravel()))
            move, spin = (part.reshape(-1, 3) for part in np.split(step, [3 * len(free)]))
            length, F, y = 2.0, np.inf, x
            while F > E and length > 1e-6:
                length /= 2
                y = x.copy()
                y[free] += length * move
                Q = Rotation.from_rotvec(length * spin).as_matrix() @ R
                F = self.energy(y, Q)
            if not F < E * (1 - 1e-12):
                break
            x, R, E = y, Q, F
        return x, E
