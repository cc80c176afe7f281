# SPDX-License-Identifier: GPL-3.0-or-later
"""Cage coordinates by other ways: quadrature, and the papers' own formulas with 60 digits."""

import mpmath as mp
import numpy as np

mp.mp.dps = 60


def triangle_nodes(n: int) -> tuple[np.ndarray, np.ndarray]:
    """(n^2, 3) barycentric coordinates and (n^2,) weights of sum 1: Gauss-Legendre in a collapsed square."""
    x, w = np.polynomial.legendre.leggauss(n)
    x, w = (x + 1) / 2, w / 2
    u, v = np.meshgrid(x, x, indexing="ij")
    shares = np.stack([1 - u, u * (1 - v), u * v], -1).reshape(-1, 3)
    return shares, (2 * np.outer(w * x, w)).ravel()


def mean_value_by_quadrature(vertices, triangles, x, n: int = 60) -> np.ndarray:
    """Integrals over the unit sphere around x of each hat function over its distance, of sum 1."""
    shares, weights = triangle_nodes(n)
    total = np.zeros(len(vertices))
    for corners in triangles:
        a, b, c = vertices[corners]
        y = shares @ vertices[corners] - x
        area = np.cross(b - a, c - a) / 2
        distance = np.linalg.norm(y, axis=1)
        sphere = weights * (y @ area) / distance**3  # the sphere's area that the piece of the triangle covers
        np.add.at(total, corners, shares.T @ (sphere / distance))
    return total / total.sum()


def green_by_quadrature(vertices, triangles, x, n: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """The single and double layers of Green's third identity."""
    shares, weights = triangle_nodes(n)
    phi, psi = np.zeros(len(vertices)), []
    for corners in triangles:
        a, b, c = vertices[corners]
        y = shares @ vertices[corners] - x
        area = np.cross(b - a, c - a) / 2
        distance = np.linalg.norm(y, axis=1)
        psi.append((weights / distance).sum() * np.linalg.norm(area) / (4 * np.pi))
        np.add.at(phi, corners, shares.T @ (weights * (y @ area) / distance**3) / (4 * np.pi))
    return phi, np.array(psi)


def _vector(row) -> mp.matrix:
    return mp.matrix([mp.mpf(float(value)) for value in row])


def _dot(a, b):
    return sum(a[i] * b[i] for i in range(3))


def _cross(a, b) -> mp.matrix:
    return mp.matrix([a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3] for i in range(3)])


def _norm(a):
    return mp.sqrt(_dot(a, a))


def exact_mean_value(vertices, triangles, x) -> np.ndarray:
    """Ju, Schaefer & Warren 2005, equations 7 to 11, off the faces."""
    rays = [_vector(row) - _vector(x) for row in vertices]
    units = [r / _norm(r) for r in rays]
    total = [mp.mpf(0)] * len(vertices)
    for corners in np.asarray(triangles).tolist():
        u = [units[v] for v in corners]
        normals = [_cross(u[(i + 1) % 3], u[(i + 2) % 3]) for i in range(3)]
        mean = mp.matrix([0, 0, 0])
        for i, normal in enumerate(normals):
            length = _norm(normal)
            mean += normal * (mp.atan2(length, _dot(u[(i + 1) % 3], u[(i + 2) % 3])) / (2 * length))
        volume = _dot(u[0], normals[0])
        if abs(volume) > mp.mpf(10) ** -50:
            for i, v in enumerate(corners):
                total[v] += _dot(normals[i], mean) / (volume * _norm(rays[v]))
    whole = sum(total)
    return np.array([float(w / whole) for w in total])


def exact_green(vertices, triangles, x) -> tuple[np.ndarray, np.ndarray]:
    """Layers of constant and linear densities on each triangle, by potentials of its edges; off the faces."""
    rays = [_vector(row) - _vector(x) for row in vertices]
    phi, psi = [mp.mpf(0)] * len(vertices), []
    for corners in np.asarray(triangles).tolist():
        r = [rays[v] for v in corners]
        d = [_norm(ray) for ray in r]
        area = _cross(r[1] - r[0], r[2] - r[0])
        volume = _dot(r[0], _cross(r[1], r[2]))
        angle = 2 * mp.atan2(
            volume,
            d[0] * d[1] * d[2] + sum(_dot(r[i], r[(i + 1) % 3]) * d[(i + 2) % 3] for i in range(3)),
        )
        # The gradient of the single layer of constant density 1, from which the other layers follow.
        normal = area / _norm(area)
        gradient, single = -normal * angle, -_dot(normal, r[0]) * angle
        logs = []
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            side = r[b] - r[a]
            length = _norm(side)
            log = mp.log((d[b] * length + _dot(r[b], side)) / (d[a] * length + _dot(r[a], side)))
            outward = _cross(side / length, normal)
            single += _dot(outward, r[a]) * log
            gradient -= outward * log
            logs.append(log)
        psi.append(float(single / (4 * mp.pi)))
        # The double layer of the barycentric coordinate of corner i: its gradient times the height sends
        # the gradient of the single layer along the side.
        height = _dot(normal, r[0])
        for i, v in enumerate(corners):
            a, b = r[(i + 1) % 3], r[(i + 2) % 3]
            slope = _cross(normal, b - a) / _norm(area)  # of the coordinate, in the plane
            foot = _dot(slope, -a)
            phi[v] += (foot * angle + height * _dot(slope, gradient)) / (4 * mp.pi)
    return np.array([float(value) for value in phi]), np.array(psi)
