# SPDX-License-Identifier: GPL-3.0-or-later
"""Methods that edit animations: their handles are edited at keys, and the frames between follow."""

from .schema import Family, Method, factorising
from .surface_nonlinear import ROWS as _SURFACE_NONLINEAR, STEPS

_ARAP = next(row for row in _SURFACE_NONLINEAR if row.id == "arap")


ROWS = (
    Method(
        id="mesh_sequence",
        number=27,
        label="Keyed Bend",
        known_as="Mesh Sequence",
        search="animation cache alembic shot jiggle fix",
        family=Family.SURFACE_NONLINEAR,
        section="6",
        paper="Xu et al. 2007",
        summary="Edits a moving mesh at keys; the frames between follow",
        fails="Follows only frames that the animation has",
        picture="mesh_sequence",
        bind_seconds=factorising(0.12),
        keyed=True,
        **STEPS,
        main=("rigidity",),
        parameters=_ARAP.parameters,
    ),
)
