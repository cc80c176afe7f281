# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape deformation: NumPy in, NumPy out. See help() of each name for shapes, units and errors."""

from ._cage import *
from ._core import *
from ._curves import *
from ._enclosure import *
from ._fields import *
from ._lattice import *
from ._mesh import *
from ._operators import *
from ._points import *
from ._skeleton import *
from ._solvers import *
from ._space import *
from ._space_handles import *
from ._subdivision import *
from ._surface import *

__version__: str
