# SPDX-License-Identifier: GPL-3.0-or-later
"""The errors an artist can meet. Each says what is wrong and what to do about it."""

from . import status


class SinewError(Exception):
    """Anything Sinew refuses to do.

    ``elements`` are indices of the elements at fault (vertices, faces, ...; ``element_kind`` names which),
    so that **Select** can show them. ``remedy`` is what a button beside the message offers.
    """

    remedy = status.Remedy.NONE

    def __init__(
        self,
        message: str,
        elements: tuple[int, ...] = (),
        element_kind: str = "",
        remedy: status.Remedy | None = None,
    ) -> None:
        super().__init__(message)
        self.elements = tuple(int(element) for element in elements)
        self.element_kind = element_kind
        if remedy is not None:
            self.remedy = remedy


class BackendMissingError(SinewError):
    """The native module cannot be used in this Blender."""

    remedy = status.Remedy.PREFERENCES


class MeshError(SinewError):
    """The mesh cannot be bound."""


class ConstraintError(SinewError):
    """The handles contradict each other, or name vertices that are not there."""


class CageError(SinewError):
    """The cage cannot move the mesh. Elements are those of the cage."""


class OptionError(SinewError):
    """A parameter is out of its range."""


class SolverError(SinewError):
    """The equations have no unique answer."""


class OutOfMemoryError(SolverError):
    """The factor would take more than the memory limit allows, or than the machine has."""

    remedy = status.Remedy.PREFERENCES


class CancelledError(SinewError):
    """The user, or a script, stopped the work."""

    remedy = status.Remedy.BIND


class UnforeseenError(SinewError):
    """A mistake in Sinew itself ended the work of a thread."""

    remedy = status.Remedy.BIND


class TopologyChangedError(SinewError):
    """The mesh no longer has the vertices it was bound with."""

    remedy = status.Remedy.BIND
