# SPDX-License-Identifier: GPL-3.0-or-later
"""What deformers move, by the names that files keep."""

from __future__ import annotations

import pytest

from sinew.core import kinds

KINDS = (kinds.MESH, kinds.SURFACE, kinds.CURVE, kinds.BEZIER, kinds.POINTCLOUD)


@pytest.mark.parametrize("kind", KINDS)
def test_a_kind_is_found_by_its_name(kind):
    assert kinds.named(kind.id) is kind


@pytest.mark.parametrize("name", [None, "", "mesh", 7, [1, 2], {"a": 1}])
def test_what_files_may_hold_instead_counts_as_a_mesh(name):
    assert kinds.named(name) is kinds.MESH


def test_names_differ_and_handles_are_parts():
    assert len({kind.id for kind in KINDS}) == len(KINDS)
    assert [kind.parts for kind in KINDS] == [1, 1, 1, 3, 1]
