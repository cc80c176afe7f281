# SPDX-License-Identifier: GPL-3.0-or-later
"""The only room that imports the native module."""

from .loader import Availability
from .native import (
    Diagnosis,
    Factor,
    PreparedBind,
    automatic_cage,
    availability,
    bind_seconds,
    build_factor,
    connected_parts,
    diagnose,
    limit_memory,
    limit_threads,
    mesh_transfer,
    sketched,
    sketched_part,
)
from .puppet import Bones, Puppet, Solution, Targets
from .recipes import (
    Base,
    Cage,
    CageReport,
    ControlPoints,
    HandlePoints,
    Handles,
    Progress,
    Recipe,
    Shape,
    handle_points,
)
from .self_check import Check, check_installation, last_check

__all__ = (
    "Availability",
    "Base",
    "Bones",
    "Cage",
    "CageReport",
    "Check",
    "ControlPoints",
    "Diagnosis",
    "Factor",
    "HandlePoints",
    "Handles",
    "PreparedBind",
    "Progress",
    "Puppet",
    "Recipe",
    "Shape",
    "Solution",
    "Targets",
    "automatic_cage",
    "availability",
    "bind_seconds",
    "build_factor",
    "check_installation",
    "connected_parts",
    "diagnose",
    "handle_points",
    "last_check",
    "limit_memory",
    "limit_threads",
    "mesh_transfer",
    "sketched",
    "sketched_part",
)
