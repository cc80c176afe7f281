# SPDX-License-Identifier: GPL-3.0-or-later
"""The rules between rooms, the completeness of the method registry, and the state of the sources."""
