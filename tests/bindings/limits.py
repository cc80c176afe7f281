# SPDX-License-Identifier: GPL-3.0-or-later
"""Limits of the module that end with their block."""

from collections.abc import Iterator
from contextlib import contextmanager

import sinew_native as sn


@contextmanager
def memory(size: int) -> Iterator[None]:
    """What takes more bytes is refused."""
    sn.limit_memory(size)
    try:
        yield
    finally:
        sn.limit_memory(0)


@contextmanager
def threads(count: int) -> Iterator[None]:
    sn.limit_threads(count)
    try:
        yield
    finally:
        sn.limit_threads(0)
