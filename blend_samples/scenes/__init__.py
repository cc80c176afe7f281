# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples with a story of their own: the first line of each script says what its picture shows."""
