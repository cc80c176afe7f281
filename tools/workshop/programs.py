# SPDX-License-Identifier: GPL-3.0-or-later
"""A program of at most twelve lines for each method, which its page shows, and which runs as it stands."""

EGG = """\
import numpy as np, sinew_native as sn
corners = np.array([(x, y, z) for z in (-4.0, 4.0) for y in (-2.0, 2.0) for x in (-2.0, 2.0)])
sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
smooth = sn.SubdivisionSurface(sn.SurfaceMesh(corners, sides), level=4)
mesh = sn.SurfaceMesh(smooth.refine(corners), smooth.faces)  # an egg of 1538 vertices
"""
SHEET = """\
import numpy as np, sinew_native as sn
y, x = np.mgrid[-4.0:4.0:41j, -1.0:1.0:11j]
points = np.column_stack((x.ravel(), 0.0 * x.ravel(), y.ravel()))
first = (11 * np.arange(40)[:, None] + np.arange(10)).ravel()
mesh = sn.SurfaceMesh(points, np.column_stack((first, first + 1, first + 12, first + 11)))
"""
ENDS = "ends = [np.flatnonzero(sign * mesh.points[:, 2] > 2.0) for sign in (-1.0, 1.0)]\n"
HELD = """\
held = [mesh.points[sign * mesh.points[:, 2] > 2.0][::10] for sign in (-1.0, 1.0)]
points, counts = np.concatenate(held), [len(end) for end in held]
"""
TURN = "turn = [(0.6, 0.0, 0.8, 1.0), (0.0, 1.0, 0.0, 0.0), (-0.8, 0.0, 0.6, 1.0)]  # and a move\n"
HANDLES = "method.set_handles(ends)  # computes the factor once\n"
POINTS = "method.bind(mesh.points)  # computes the weights once\n"
SOLVE = "positions, report = method.solve([np.eye(3, 4), turn])  # in every frame\n"
WARP = "positions = method.warp({})  # in every frame\n"
LIFT = "posed = {} + np.where(corners[:, 2:] > 0.0, (2.0, 0.0, 1.0), 0.0)  # the upper four move\n"

SURFACE = EGG + ENDS + "method = sn.{}\n" + HANDLES + TURN + SOLVE
AMONG_HANDLES = EGG + HELD + "method = sn.{}\n" + POINTS + TURN
AMONG_HANDLES += "positions = method.warp_poses([np.eye(3, 4), turn])  # in every frame\n"
IN_CAGE = EGG + "cage = sn.SurfaceMesh(1.1 * corners, sides)\nmethod = sn.{}\n" + POINTS
IN_CAGE += LIFT.format("cage.points") + WARP.format("posed")
IN_LATTICE = EGG + "method = sn.{}\n" + POINTS + LIFT.format("corners") + WARP.format("posed")

# The words of the constructors that take more than all others of their kind.
ARGUMENTS = {
    "multiresolution": "mesh, sn.ThinShell(mesh)",
    "multiresolution_space": "points, sn.Rbf(points, counts), mesh, counts",
    "embedded_deformation": "mesh, points, counts",
    "rigid_cells": "mesh, points, counts",
}
OTHERS = {
    "spline_surface": SURFACE.replace(EGG, SHEET).format("SplineSurface(mesh)"),
    "pyramid_coordinates": f"""{EGG}\
twin = sn.SurfaceMesh(mesh.points * (1.0, 2.0, 0.5), smooth.faces)
method = sn.PyramidCoordinates(mesh, target_shape=twin)
method.set_handles([])  # computes the factor once; handles may hold parts
positions, report = method.solve([], morph=0.5)  # halfway, in every frame
""",
    "mesh_sequence": f"""{EGG}{ENDS}\
method = sn.MeshSequence(mesh)
{HANDLES}{TURN}\
still, edit = np.ravel(np.eye(3, 4)), np.ravel(turn)
keys = [(1.0, 1.0, *still), (20.0, 1.0, *edit)]  # frame, handle, map
positions, report = method.solve_frame(10.0, keys=keys, incoming=mesh.points)  # in every frame
""",
    "mesh_puppetry": f"""{EGG}\
bones = sn.Skeleton([(0.0, 0.0, -3.0), (0.0, 0.0, 0.0)], [(0.0, 0.0, 0.0), (0.0, 0.0, 3.0)], [-1, 0])
method = sn.MeshPuppetry(mesh)
method.set_handles(bones.regions(mesh))  # computes the factor once
poses = bones.poses([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])  # the upper bone turns
positions, report = method.solve(poses)  # in every frame
""",
    "wires": f"""{EGG}\
wire = np.linspace((1.2, 0.0, -3.0), (1.2, 0.0, 3.0), 20)
method = sn.Wires(wire, radius=1.5)
{POINTS}\
{WARP.format("wire + 0.1 * wire[:, 2:] ** 2 * (1.0, 0.0, 0.0)")}""",
    "vector_field": f"""{EGG}\
tool = np.concatenate((np.zeros((1, 3)), np.eye(3))) + (0.0, 0.0, 2.0)  # an origin, and the ends of axes
method = sn.VectorField(np.tile(tool, (2, 1)), [2], inner=0.5, outer=2.0)
method.bind(mesh.points)  # keeps them
path = np.concatenate((tool, tool + (1.0, 0.0, 1.0)))
{WARP.format("path")}""",
}


def program(row) -> str:
    """For a row of the registry."""
    if row.id in OTHERS:
        return OTHERS[row.id]
    pattern, words = {
        "HANDLES": (AMONG_HANDLES, "points, counts") if row.is_space else (SURFACE, "mesh"),
        "CAGE": (IN_CAGE, "cage"),
        "LATTICE": (IN_LATTICE, "corners"),
    }[row.control.name]
    return pattern.format(f"{row.native}({ARGUMENTS.get(row.id, words)})")
