# SPDX-License-Identifier: GPL-3.0-or-later
"""Limits of the module that end with their block."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

import sinew_native as sn


@contextmanager
def _limited(limit: Callable[[int], None], value: int) -> Iterator[None]:
    limit(value)
    try:
        yield
    finally:
        limit(0)


memory = partial(_limited, sn.limit_memory)  # of so many bytes: what takes more is refused
threads = partial(_limited, sn.limit_threads)
