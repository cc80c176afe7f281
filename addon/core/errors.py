# SPDX-License-Identifier: GPL-3.0-or-later
"""The errors an artist can meet. Each says what is wrong and what to do about it."""


class SinewError(Exception):
    """Anything Sinew refuses to do.

    ``elements`` are indices of the elements at fault (vertices, faces, ...; ``element_kind`` names which),
    so that **Select** can show them.
    """

    def __init__(self, message: str, elements: tuple[int, ...] = (), element_kind: str = "") -> None:
        super().__init__(message)
        self.elements = tuple(int(element) for element in elements)
        self.element_kind = element_kind


class BackendMissingError(SinewError):
    """The native module cannot be used in this Blender."""


class MeshError(SinewError):
    """The mesh cannot be bound."""


class ConstraintError(SinewError):
    """The handles contradict each other, or name vertices that are not there."""


class OptionError(SinewError):
    """A parameter is out of its range."""


class SolverError(SinewError):
    """The equations have no unique answer."""


class CancelledError(SinewError):
    """The user, or a script, stopped the work."""


class TopologyChangedError(SinewError):
    """The mesh no longer has the vertices it was bound with."""
