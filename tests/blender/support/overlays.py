# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of overlays share."""

OPACITY = 0.5
