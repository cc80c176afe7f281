# SPDX-License-Identifier: GPL-3.0-or-later
"""The errors an artist can meet. Each says what is wrong and what to do about it."""

from . import status
from .elements import NO_ELEMENTS, Elements


class SinewError(Exception):
    """Anything Sinew refuses to do.

    ``elements`` are those at fault, so that **Select** can show them. ``remedy`` is what a button beside the
    message offers.
    """

    remedy = status.Remedy.NONE

    def __init__(
        self,
        message: str,
        elements: Elements = NO_ELEMENTS,
        remedy: status.Remedy | None = None,
    ) -> None:
        super().__init__(message)
        self.elements = elements
        if remedy is not None:
            self.remedy = remedy

    def about(self, elements: Elements, remedy: status.Remedy) -> "SinewError":
        """The same refusal, of other elements and with another remedy."""
        return type(self)(str(self), elements, remedy)


class BackendMissingError(SinewError):
    """The native module cannot be used in this Blender."""

    remedy = status.Remedy.PREFERENCES


class MeshError(SinewError):
    """The mesh cannot be bound."""


class ConstraintError(SinewError):
    """The handles contradict each other, or name vertices that are not there."""


class CageError(SinewError):
    """The cage cannot move the mesh."""


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
