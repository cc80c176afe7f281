# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads sinew_native and poses a small sheet, in any Python, also Blender's: ``check_module.py [FOLDER]``.

The module has to come from FOLDER, where there is one.
"""

import sys


def pose_a_sheet(sinew_native):
    """Poses a sheet of 41 x 41 points, with one side fixed and the other lifted, by both handle methods."""
    import numpy

    side = 41
    ticks = numpy.linspace(0.0, 1.0, side)
    points = numpy.array([(x, y, 0.0) for y in ticks for x in ticks])
    corners = numpy.arange(side * side).reshape(side, side)[:-1, :-1].reshape(-1, 1)
    faces = corners + (0, 1, side + 1, side)
    handles = [numpy.arange(3 * side), numpy.arange((side - 3) * side, side * side)]
    poses = numpy.tile(numpy.eye(3, 4), (2, 1, 1))
    poses[1, 2, 3] = 0.25
    mesh = sinew_native.SurfaceMesh(points, faces)
    for method in (sinew_native.ThinShell(mesh), sinew_native.Arap(mesh)):
        method.set_handles(handles)
        posed, report = method.solve(poses)
        assert numpy.isfinite(posed).all(), report
        assert numpy.allclose(posed[handles[1], 2], 0.25, atol=1e-9), report
        assert 0.05 < posed[side * (side // 2), 2] < 0.2, posed[side * (side // 2)]


def refine_and_enclose(sinew_native):
    """Subdivides a cube, and makes a cage around it."""
    import numpy

    points = numpy.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    smooth = sinew_native.SubdivisionSurface(sinew_native.SurfaceMesh(points, faces), level=2)
    target = sinew_native.SurfaceMesh(smooth.refine(points), smooth.faces)
    cage = sinew_native.SurfaceMesh(*sinew_native.automatic_cage(target, 60, 0.1)[:2])
    assert sinew_native.diagnose_cage(cage, target.points).clean


def main(folders):
    sys.path[:0] = folders
    import sinew_native

    pose_a_sheet(sinew_native)
    refine_and_enclose(sinew_native)
    assert all(sinew_native.__file__.startswith(folder) for folder in folders), sinew_native.__file__
    print(f"sinew_native {sinew_native.__version__} works in Python {sys.version.split()[0]}")


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:])
