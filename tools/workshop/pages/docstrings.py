# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows the docstrings of `sinew_native` as they stand: they are tables in plain text, and no Markdown."""

import griffe


class PlainText(griffe.Extension):
    def on_object(self, *, obj: griffe.Object, **_others: object) -> None:
        if obj.docstring:
            obj.docstring.value = f"```{{.text .docstring}}\n{obj.docstring.value}\n```"
