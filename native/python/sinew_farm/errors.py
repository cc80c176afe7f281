# SPDX-License-Identifier: GPL-3.0-or-later
"""What the commands of this package end with."""

from .atom import CRASHED


class FarmError(RuntimeError):
    """Why a bake or a sweep ended, with the exit code of the command: that of the bake (2, 3, 4, 5), or 1."""

    def __init__(self, message: str, code: int = CRASHED) -> None:
        super().__init__(message)
        self.code = code
