# SPDX-License-Identifier: GPL-3.0-or-later
"""The errors that an artist can meet. Each message says what is wrong, where, and what to do about it."""

from . import status
from .elements import NO_ELEMENTS, Elements


class SinewError(Exception):
    """Sinew refuses to do something. All errors that an artist can meet derive from this class.

    ``elements`` are the elements at fault, which the button **Select** shows. ``remedy`` is what another
    button beside the message does.
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

    def with_elements(self, elements: Elements, remedy: status.Remedy, text: str = "") -> "SinewError":
        """The same error with other elements, another remedy and, if it is given, another text."""
        return type(self)(text or str(self), elements, remedy)


class BackendMissingError(SinewError):
    """The native module cannot be used in this Blender."""

    remedy = status.Remedy.PREFERENCES


class MeshError(SinewError):
    """The mesh cannot be bound."""


class ConstraintError(SinewError):
    """The handles contradict each other, or they name vertices that do not exist."""


class CageError(SinewError):
    """The cage cannot move the mesh."""


class OutsideError(CageError):
    """Points lie outside the cage, and the method cannot move them there. The elements are these points."""

    remedy = status.Remedy.OUTSIDE | status.Remedy.QUICK_CAGE


class OptionError(SinewError):
    """A parameter is out of its range."""


class SolverError(SinewError):
    """The equations have no unique answer."""


class OutOfMemoryError(SolverError):
    """A bind needs more memory than the memory limit allows, or than the machine has."""

    remedy = status.Remedy.PREFERENCES


class CancelledError(SinewError):
    """A user or a script cancelled the work."""

    remedy = status.Remedy.BIND


class FactorInUseError(SinewError):
    """A factor is asked for something within the bind that it belongs to, for which it cannot wait."""

    remedy = status.Remedy.BIND


class UnforeseenError(SinewError):
    """A thread ended with an exception that Sinew did not foresee, which is a bug in Sinew."""

    remedy = status.Remedy.BIND


class TopologyChangedError(SinewError):
    """The mesh no longer has the vertices it was bound with."""

    remedy = status.Remedy.BIND
