# SPDX-License-Identifier: GPL-3.0-or-later
"""The energy of an embedded deformation by the paper's sums, and Gauss-Newton steps: oracle and peer."""

from collections.abc import Iterator

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

WEIGHTS = {"rotation": 1.0, "regularity": 10.0, "pulls": 100.0}
PRODUCTS = [(a, b) for a in range(3) for b in range(3)]  # of columns; the paper has those of two once


class PaperEnergy:
    """The residuals of Sumner, Schmid & Pauly 2007 over A_j and t_j, in mean edges, and their derivatives."""

    def __init__(self, graph: dict, targets: np.ndarray) -> None:
        self.unit = graph["edge_length"]
        self.nodes, self.targets = graph["nodes"] / self.unit, targets / self.unit
        j, k = np.concatenate([graph["edges"], np.fliplr(graph["edges"])]).T
        m, rows, ways = len(self.nodes), np.arange(len(j)), self.nodes[k] - self.nodes[j]
        # Rows (r, m, 4) over the columns of A_j and t_j: A_j (g_k - g_j) + t_j - t_k = g_k - g_j
        regular = np.zeros((len(j), m, 4))
        regular[rows, j] = np.column_stack([ways, np.ones(len(j))])
        regular[rows, k, 3] = -1.0
        # and the sum of w_j (A_j (p - g_j) + t_j + g_j) = the target of p.
        weights, away = graph["pull_weights"], graph["pulls"][:, None] / self.unit - self.nodes
        pulled = weights[:, :, None] * np.concatenate([away, np.ones((*away.shape[:2], 1))], -1)
        squares = [WEIGHTS["regularity"]] * len(j), WEIGHTS["pulls"] * graph["strengths"]
        roots = np.sqrt(np.concatenate(squares))[:, None]
        left = np.concatenate([regular, pulled]).reshape(-1, 4 * m)
        self.linear = sparse.csr_matrix(roots * left)
        self.right = roots * np.concatenate([ways, self.targets - weights @ self.nodes])

    def start(self) -> np.ndarray:
        x = np.zeros((len(self.nodes), 4, 3))
        x[:, :3] = np.eye(3)
        return x

    def rotations(self, x: np.ndarray) -> np.ndarray:
        A = x[:, :3].transpose(0, 2, 1)  # rows of x are the columns of A
        S = A.transpose(0, 2, 1) @ A - np.eye(3)
        return np.sqrt(WEIGHTS["rotation"]) * np.stack([S[:, a, b] for a, b in PRODUCTS], 1)

    def residual(self, flat: np.ndarray) -> np.ndarray:
        x = flat.reshape(-1, 4, 3)
        linear = self.linear @ x.reshape(-1, 3) - self.right
        return np.concatenate((self.rotations(x).ravel(), linear.ravel()))

    def jacobian(self, flat: np.ndarray) -> sparse.csr_matrix:
        x = flat.reshape(-1, 4, 3)
        m, root = len(x), np.sqrt(WEIGHTS["rotation"])
        rows, columns, values = [], [], []
        for e, (a, b) in enumerate(PRODUCTS):
            for own, other in ((a, b), (b, a)):
                rows.append(np.repeat(len(PRODUCTS) * np.arange(m) + e, 3))
                columns.append(((4 * np.arange(m) + own)[:, None] * 3 + np.arange(3)).ravel())
                values.append(root * x[:, other].ravel())
        values, rows, columns = map(np.concatenate, (values, rows, columns))
        quartic = sparse.csr_matrix((values, (rows, columns)), (len(PRODUCTS) * m, 12 * m))
        return sparse.vstack((quartic, sparse.kron(self.linear, sparse.eye(3)))).tocsr()

    def energy(self, flat: np.ndarray) -> float:
        return float(np.sum(self.residual(flat) ** 2))

    def gauss_newton(self, steps: int = 60) -> np.ndarray:
        """The last of some damped steps from rest, of which each factorises the normal equations."""
        return list(self.iterates(steps))[-1]

    def iterates(self, steps: int) -> Iterator[np.ndarray]:
        """The shapes after each step, until these rest."""
        flat = self.start().ravel()
        for _ in range(steps):
            J, r = self.jacobian(flat), self.residual(flat)
            step = spsolve((J.T @ J + 1e-9 * sparse.eye(len(flat))).tocsc(), J.T @ r)
            length, before = 1.0, float(np.sum(r**2))
            while self.energy(flat - length * step) > before and length > 1e-6:
                length *= 0.5
            flat = flat - length * step
            yield flat
            if np.abs(step).max() < 1e-10:
                return

    def warped(self, flat: np.ndarray, points: np.ndarray, weights: sparse.csr_matrix) -> np.ndarray:
        """Where the nodes take points (n, 3) that follow them by ``weights`` (n, m)."""
        x = flat.reshape(-1, 4, 3)
        places = self.unit * (self.nodes + x[:, 3])
        offsets = places - np.einsum("jcx,jc->jx", x[:, :3], self.unit * self.nodes)
        maps = weights @ np.concatenate((x[:, :3].reshape(-1, 9), offsets), 1)
        return np.einsum("ncx,nc->nx", maps[:, :9].reshape(-1, 3, 3), points) + maps[:, 9:]
