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


def crosses(turned: np.ndarray, group: np.ndarray, groups: int) -> sparse.csr_matrix:
    """(3 m, 3 groups) the matrices of turned x at the columns of their groups."""
    rows = 3 * np.arange(len(group))[:, None, None] + np.arange(3)[:, None] + np.zeros(3, int)
    columns = 3 * group[:, None, None] + np.zeros((3, 1), int) + np.arange(3)
    blocks = -np.cross(turned[:, None], np.eye(3))
    return sparse.csr_matrix((blocks.ravel(), (rows.ravel(), columns.ravel())), (3 * len(group), 3 * groups))


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

    def slopes(self, R: np.ndarray) -> sparse.csr_matrix:
        """(3 m, 3 groups): how the residuals change as rotations turn."""
        return crosses(self.turned(R), self.group, len(R))

    def minimum(self, x: np.ndarray, free: np.ndarray, R: np.ndarray | None = None, loose=None) -> tuple:
        """Over free points and rotations, all unless told, from a start: points, their energy, rotations."""
        root = sparse.diags(np.sqrt(np.repeat(self.weight, 3)))
        of_points = sparse.kron(self.D[:, free], sparse.identity(3), format="csr")
        R = self.rotations(x) if R is None else R
        loose = np.arange(len(R)) if loose is None else loose
        columns, E = (3 * loose[:, None] + np.arange(3)).ravel(), self.energy(x, R)
        for _ in range(200):
            J = root @ sparse.hstack([of_points, self.slopes(R)[:, columns]])
            A = (J.T @ J).tocsc()
            A += 1e-10 * A.diagonal().mean() * sparse.identity(A.shape[0])
            step = -splu(A.tocsc()).solve(J.T @ (root @ (self.D @ x - self.turned(R)).ravel()))
            move, spin = (part.reshape(-1, 3) for part in np.split(step, [3 * len(free)]))
            length, F, y, Q = 2.0, np.inf, x.copy(), R.copy()
            while F > E and length > 1e-6:
                length /= 2
                y[free] = x[free] + length * move
                Q[loose] = Rotation.from_rotvec(length * spin).as_matrix() @ R[loose]
                F = self.energy(y, Q)
            if not F < E * (1 - 1e-12):
                break
            x, R, E = y, Q, F
        return x, E, R
