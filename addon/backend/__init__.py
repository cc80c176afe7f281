# SPDX-License-Identifier: GPL-3.0-or-later
"""The only room that imports the native module."""

from .loader import Availability as Availability
from .native import (
    Diagnosis as Diagnosis,
    Factor as Factor,
    PreparedBind as PreparedBind,
    automatic_cage as automatic_cage,
    availability as availability,
    bind_seconds as bind_seconds,
    build_factor as build_factor,
    connected_parts as connected_parts,
    diagnose as diagnose,
    limit_memory as limit_memory,
    limit_threads as limit_threads,
    mesh_transfer as mesh_transfer,
    sketched as sketched,
    sketched_part as sketched_part,
)
from .puppet import Bones as Bones, Puppet as Puppet, Solution as Solution, Targets as Targets
from .recipes import (
    Apart as Apart,
    Around as Around,
    AxisBox as AxisBox,
    Base as Base,
    BoxShare as BoxShare,
    CageReport as CageReport,
    ControlPoints as ControlPoints,
    Faces as Faces,
    HandlePoints as HandlePoints,
    Progress as Progress,
    Recipe as Recipe,
    Refusal as Refusal,
    Regions as Regions,
    Shape as Shape,
)
from .self_check import Check as Check, check_installation as check_installation, last_check as last_check
from .surfaces import (
    Carried as Carried,
    Curvature as Curvature,
    Lined as Lined,
    RefinedSurface as RefinedSurface,
    Subdivision as Subdivision,
    Survey as Survey,
    curvature as curvature,
    decimate as decimate,
    remesh as remesh,
    remove_degenerate as remove_degenerate,
    semi_regular as semi_regular,
    survey as survey,
)
