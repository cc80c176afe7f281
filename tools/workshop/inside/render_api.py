# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a module as web pages: ``render_api.py MODULE TARGET``, by a Python that has the package ``pdoc``.

The docstrings of the compiled module are tables in plain text, so they are shown as they stand, without the
first line in which pybind11 repeats the signature.
"""

import sys
import tempfile
from pathlib import Path

import pdoc
from pdoc.doc import Doc, Function

TEMPLATE = """{% extends "default/module.html.jinja2" %}
{% block style %}
{{ super() }}
<style>.pdoc-docstring pre { white-space: pre-wrap; font-size: 0.72rem }</style>
{% endblock %}
{% macro docstring(var) %}
    {% if var.docstring %}
    <div class="pdoc-docstring"><pre>{{ var | plain_docstring | escape }}</pre></div>
    {% endif %}
{% endmacro %}
"""


def plain_docstring(documented: Doc) -> str:
    """The docstring without the signature that pybind11 puts above it."""
    first, _, rest = documented.docstring.partition("\n")
    is_signed = isinstance(documented, Function) and first.startswith(f"{documented.name}(")
    return (rest if is_signed else documented.docstring).strip()


def main(module: str, target: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "module.html.jinja2").write_text(TEMPLATE, encoding="utf-8")
        pdoc.render.configure(template_directory=Path(folder), search=True)
        pdoc.render.env.filters["plain_docstring"] = plain_docstring
        pdoc.pdoc(module, output_directory=target)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
