# SPDX-License-Identifier: GPL-3.0-or-later
from typing import Literal

from numpy.typing import ArrayLike
from scipy.sparse import spmatrix

from ._types import Floats

class SpdFactor:
    def __init__(
        self,
        matrix: spmatrix,
        ordering: Literal[
            "natural", "reverse_cuthill_mckee", "minimum_degree", "nested_dissection"
        ] = "minimum_degree",
        backend: Literal["automatic", "supernodal", "simplicial", "ldlt"] = "automatic",
    ) -> None: ...
    def solve(self, rhs: ArrayLike) -> Floats: ...
    def factorize(self, matrix: spmatrix) -> None: ...
    @property
    def size(self) -> int: ...
    @property
    def nonzeros(self) -> int: ...
    @property
    def bytes(self) -> int: ...
    @property
    def factorizations(self) -> int: ...
    @property
    def analyses(self) -> int: ...
