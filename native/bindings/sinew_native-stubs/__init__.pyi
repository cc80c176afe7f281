# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape deformation: NumPy in, NumPy out. See help() of each name for shapes, units and errors."""

from ._cage import (
    CageCoordinates as CageCoordinates,
    Green as Green,
    Harmonic as Harmonic,
    MeanValue as MeanValue,
    PositiveMeanValue as PositiveMeanValue,
)
from ._core import (
    BindReport as BindReport,
    Cancelled as Cancelled,
    Error as Error,
    FactorizationFailed as FactorizationFailed,
    InvalidConstraint as InvalidConstraint,
    InvalidMesh as InvalidMesh,
    InvalidOption as InvalidOption,
    OutOfMemory as OutOfMemory,
    SolveReport as SolveReport,
    limit_memory as limit_memory,
    limit_threads as limit_threads,
)
from ._enclosure import (
    AutomaticCageReport as AutomaticCageReport,
    CageDiagnosis as CageDiagnosis,
    automatic_cage as automatic_cage,
    diagnose_cage as diagnose_cage,
)
from ._mesh import (
    Diagnosis as Diagnosis,
    SurfaceMesh as SurfaceMesh,
)
from ._operators import (
    divergence as divergence,
    fit_rotations as fit_rotations,
    gradient as gradient,
    laplacian as laplacian,
    laplacian_power as laplacian_power,
    mass as mass,
)
from ._solvers import (
    SpdFactor as SpdFactor,
)
from ._space import (
    CageReport as CageReport,
    SpaceMethod as SpaceMethod,
)
from ._subdivision import (
    SubdivisionSurface as SubdivisionSurface,
)
from ._surface import (
    AffineBasis as AffineBasis,
    Arap as Arap,
    SurfaceMethod as SurfaceMethod,
    ThinShell as ThinShell,
)

__version__: str
