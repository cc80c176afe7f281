# SPDX-License-Identifier: GPL-3.0-or-later
from workshop.coverage import table
from workshop.places import ROOT

ARAP, REGIONS = ROOT / "native/methods/surface/arap.cpp", ROOT / "native/mesh/regions.h"


def test_line_that_one_part_of_the_tests_reached_counts_as_reached() -> None:
    parts = [{ARAP: {1: True, 2: False}, REGIONS: {5: False}}, {ARAP: {2: True, 3: False}}]
    rows = [line.split() for line in table(parts)]
    assert rows[1:] == [
        ["native", "4", "50.0", "%"],
        ["native/mesh", "1", "0.0", "%"],
        ["native/methods/surface", "3", "66.7", "%"],
    ]
