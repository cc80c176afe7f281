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


def pieces(vertices, triangles, x, n: int = 60):
    """Of each triangle its corners, shares, weights, its area as a vector, and y - x (n^2, 3) on it."""
    shares, weights = triangle_nodes(n)
    for corners in triangles:
        a, b, c = vertices[corners]
        yield corners, shares, weights, np.cross(b - a, c - a) / 2, shares @ vertices[corners] - x


def mean_value_by_quadrature(vertices, triangles, x) -> np.ndarray:
    """Integrals over the unit sphere around x of each hat function over its distance, of sum 1."""
    total = np.zeros(len(vertices))
    for corners, shares, weights, area, y in pieces(vertices, triangles, x):
        distance = np.linalg.norm(y, axis=1)
        sphere = weights * (y @ area) / distance**3  # the sphere's area that the piece of the triangle covers
        np.add.at(total, corners, shares.T @ (sphere / distance))
    return total / total.sum()


def green_by_quadrature(vertices, triangles, x) -> tuple[np.ndarray, np.ndarray]:
    """The single and double layers of Green's third identity."""
    phi, psi = np.zeros(len(vertices)), []
    for corners, shares, weights, area, y in pieces(vertices, triangles, x):
        distance = np.linalg.norm(y, axis=1)
        psi.append((weights / distance).sum() * np.linalg.norm(area) / (4 * np.pi))
        np.add.at(phi, corners, shares.T @ (weights * (y @ area) / distance**3) / (4 * np.pi))
    return phi, np.array(psi)


def rays_of(vertices, x) -> np.ndarray:
    """From x to each vertex, of 60 digits."""
    exact = np.vectorize(lambda value: mp.mpf(float(value)), otypes=[object])
    return exact(vertices) - exact(x)


def norm(a):
    return mp.sqrt(a @ a)


def exact_mean_value(vertices, triangles, x) -> np.ndarray:
    """Ju, Schaefer & Warren 2005, equations 7 to 11, off the faces."""
    rays = rays_of(vertices, x)
    units = [ray / norm(ray) for ray in rays]
    total = [mp.mpf(0)] * len(vertices)
    for corners in np.asarray(triangles).tolist():
        u = [units[v] for v in corners]
        normals = [np.cross(u[(i + 1) % 3], u[(i + 2) % 3]) for i in range(3)]
        mean = 0
        for i, normal in enumerate(normals):
            length = norm(normal)
            mean += normal * (mp.atan2(length, u[(i + 1) % 3] @ u[(i + 2) % 3]) / (2 * length))
        volume = u[0] @ normals[0]
        if abs(volume) > mp.mpf(10) ** -50:
            for i, v in enumerate(corners):
                total[v] += normals[i] @ mean / (volume * norm(rays[v]))
    return np.array([float(w / sum(total)) for w in total])


def exact_green(vertices, triangles, x) -> tuple[np.ndarray, np.ndarray]:
    """Layers of constant and linear densities on each triangle, by potentials of its edges; off the faces."""
    rays = rays_of(vertices, x)
    phi, psi = [mp.mpf(0)] * len(vertices), []
    for corners in np.asarray(triangles).tolist():
        r = rays[corners]
        d = [norm(ray) for ray in r]
        area = np.cross(r[1] - r[0], r[2] - r[0])
        sides = d[0] * d[1] * d[2] + sum(r[i] @ r[(i + 1) % 3] * d[(i + 2) % 3] for i in range(3))
        angle = 2 * mp.atan2(r[0] @ np.cross(r[1], r[2]), sides)
        # The gradient of the single layer of constant density 1, from which the other layers follow.
        normal = area / norm(area)
        height = normal @ r[0]
        gradient, single = -normal * angle, -height * angle
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            side = r[b] - r[a]
            length = norm(side)
            log = mp.log((d[b] * length + r[b] @ side) / (d[a] * length + r[a] @ side))
            outward = np.cross(side / length, normal)
            single += outward @ r[a] * log
            gradient -= outward * log
        psi.append(float(single / (4 * mp.pi)))
        # The double layer of the barycentric coordinate of corner i: its gradient times the height sends
        # the gradient of the single layer along the side.
        for i, v in enumerate(corners):
            a, b = r[(i + 1) % 3], r[(i + 2) % 3]
            slope = np.cross(normal, b - a) / norm(area)  # of the coordinate, in the plane
            phi[v] += (-slope @ a * angle + height * (slope @ gradient)) / (4 * mp.pi)
    return np.array([float(value) for value in phi]), np.array(psi)
