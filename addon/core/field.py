# SPDX-License-Identifier: GPL-3.0-or-later
"""How rooms declare properties: what a property holds, and then what artists read about it."""

from functools import partial


class field(partial):
    """A property by a function of bpy.props, still without its name."""

    def named(self, name: str, description: str = ""):
        """The property with its label and its tooltip."""
        return self(name=name, description=description)
