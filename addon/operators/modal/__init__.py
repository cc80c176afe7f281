# SPDX-License-Identifier: GPL-3.0-or-later
"""Tools that run in a viewport until the artist confirms or cancels."""
