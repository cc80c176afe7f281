# SPDX-License-Identifier: GPL-3.0-or-later
"""Sockets of nodes that carry one socket per data type in older versions."""

from bpy.types import NodeSocket


def enabled_socket(sockets, name: str) -> NodeSocket | None:
    """The first enabled socket of that name."""
    return next((socket for socket in sockets if socket.name == name and socket.enabled), None)
