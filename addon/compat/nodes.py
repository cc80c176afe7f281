# SPDX-License-Identifier: GPL-3.0-or-later
"""Sockets of nodes.

In older versions such a node has one socket per data type, and one of them is enabled.
"""

from bpy.types import NodeSocket


def enabled_socket(sockets, name: str) -> NodeSocket | None:
    """The first enabled socket of that name."""
    return next((socket for socket in sockets if socket.name == name and socket.enabled), None)
