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
    Apart,
    Around,
    AxisBox,
    Base,
    BoxShare,
    CageReport,
    ControlPoints,
    Faces,
    HandlePoints,
    Progress,
    Recipe,
    Refusal,
    Regions,
    Shape,
)
from .self_check import Check, check_installation, last_check
