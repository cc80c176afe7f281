# SPDX-License-Identifier: GPL-3.0-or-later
"""Decides when to factorise and when to solve. Operators, handlers and panels import its modules."""
