# SPDX-License-Identifier: GPL-3.0-or-later
"""The models of the samples; each module has ``build() -> Object`` and gives the same mesh every time."""
