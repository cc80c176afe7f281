# SPDX-License-Identifier: GPL-3.0-or-later
import pytest

from .counts import COUNTS, Count


@pytest.mark.parametrize("count", COUNTS, ids=lambda count: count.name)
def test_no_count_passes_its_limit(count: Count) -> None:
    now = count.find()
    assert now <= count.limit, f"{count.name}: {now:g}, at most {count.limit:g}"
