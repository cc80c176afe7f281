# SPDX-License-Identifier: GPL-3.0-or-later
"""The only door to the native module."""

from .loader import Availability
from .native import Factor, Progress, availability, build_factor

__all__ = ("Availability", "Factor", "Progress", "availability", "build_factor")
