# SPDX-License-Identifier: GPL-3.0-or-later
"""The types of points that deformers move, by the identifiers that files keep."""

import pytest

from sinew.core import point_types

ALL = [getattr(point_types, name) for name in ("MESH", "SURFACE", "CURVE", "BEZIER", "POINTCLOUD")]


@pytest.mark.parametrize("point_type", ALL)
def test_a_point_type_is_found_by_its_identifier(point_type):
    assert point_types.point_type_with_id(point_type.id) is point_type


@pytest.mark.parametrize("identifier", [None, "", "mesh", 7, [1, 2], {"a": 1}])
def test_what_files_may_hold_instead_counts_as_a_mesh(identifier):
    assert point_types.point_type_with_id(identifier) is point_types.MESH


def test_identifiers_differ_and_bezier_handles_are_points():
    assert len({point_type.id for point_type in ALL}) == len(ALL)
    assert [point_type.points_per_element for point_type in ALL] == [1, 1, 1, 3, 1]
