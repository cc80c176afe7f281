# SPDX-License-Identifier: GPL-3.0-or-later
"""The functions that measure. Each gets a size and the numbers of threads, and returns rows; what a row does
not say of itself, such as its work and its size, comes from the table of works."""
