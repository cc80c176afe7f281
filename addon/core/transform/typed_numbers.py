# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers that are typed while a tool runs, one per component, as in Blender's own transforms."""

_LONGEST = 24  # characters: more digits than a float has, and far from an overflow


class TypedNumbers:
    """One text per component, of which the ``active`` one receives the keys.

    While nothing is typed, the mouse decides.
    """

    def __init__(self, count: int = 3) -> None:
        self.texts = [""] * count
        self.active = 0

    def __bool__(self) -> bool:
        return any(self.texts)

    def resize(self, count: int) -> None:
        """Change the number of components. Those that remain keep their text."""
        self.texts = (self.texts + [""] * count)[:count]
        self.active = min(self.active, count - 1)

    def clear(self) -> None:
        """Remove all texts, so that the mouse decides again."""
        self.texts = [""] * len(self.texts)
        self.active = 0

    def type(self, character: str) -> bool:
        """Process a digit, a decimal point, or a minus, which changes the sign; False for any other key."""
        text = self.texts[self.active]
        if character == "-":
            text = text[1:] if text.startswith("-") else "-" + text
        elif character and character in ".,":
            text += "" if "." in text else "."
        elif character in ("0", "1", "2", "3", "4", "5", "6", "7", "8", "9"):
            text += character
        else:
            return False
        self.texts[self.active] = text[:_LONGEST]
        return True

    def erase(self, everything: bool = False) -> None:
        """Remove the last character. From an empty component go to the previous one."""
        if everything:
            self.clear()
        elif self.texts[self.active]:
            self.texts[self.active] = self.texts[self.active][:-1]
        elif self.active:
            self.active -= 1

    def step(self, by: int) -> None:
        """Activate another component."""
        self.active = (self.active + by) % len(self.texts)

    def value(self, component: int) -> float | None:
        """The number of a component; None if nothing is typed."""
        text = self.texts[component]
        if not text:
            return None
        return float(text) if any(character.isdigit() for character in text) else 0.0

    def shown(self, component: int, value: str) -> str:
        """A component for the header. The active one shows its text with a cursor."""
        if component == self.active and self.texts[component]:
            return f"[{self.texts[component]}|] = {value}"
        return value
