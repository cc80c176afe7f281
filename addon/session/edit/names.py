# SPDX-License-Identifier: GPL-3.0-or-later
"""Names for new rows of a list."""


def unique_name(name: str, taken: list[str]) -> str:
    """The name, with a number after it if it is taken."""
    if name not in taken:
        return name
    return next(f"{name}.{number:03}" for number in range(1, 1000) if f"{name}.{number:03}" not in taken)
