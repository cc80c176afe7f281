# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on runs nothing that a file brings: no code from data, no process, no network, no pickles."""

import ast
from collections.abc import Iterator
from pathlib import Path

from .tree import files

# Modules that turn data into code or objects, start processes, or reach the network.
MODULES = {
    *("asyncio", "code", "codeop", "copyreg", "ctypes", "dill", "ftplib", "http", "jsonpickle", "marshal"),
    *("multiprocessing", "pickle", "pty", "requests", "runpy", "shelve", "smtplib", "socket", "ssl"),
    *("subprocess", "telnetlib", "urllib", "xmlrpc", "yaml", "zipimport"),
}
# Functions for addon/bake alone.
WRITING = {"extract", "extractall", "mkdir", "rmtree", "touch", "unlink", "write_bytes", "write_text"}
OPENING = {"NamedTemporaryFile", "TemporaryDirectory", "TemporaryFile", "mkstemp", "open"}
CALLS = {"eval", "exec", "compile", "__import__", "input", "globals", "locals"}
ATTRIBUTES = {
    *("driver_namespace", "expression", "fork", "fromfile", "import_module", "loads", "popen", "spawnl"),
    *("spawnv", "startfile", "use_scripts", "use_scripts_auto_execute"),
}
OF_MODULES = {("os", "system"), ("np", "load"), ("np", "save"), ("numpy", "load"), ("numpy", "save")}
OPERATORS = {"script", "console", "text", "preferences", "extensions"}  # of bpy.ops
# What may be there, and why.
ALLOWED = {
    ("backend/loader.py", "import_module"): "the native module, by a name of our own",
    ("backend/loader.py", "extractall"): "the native module, from the wheel that came with the zip",
    ("backend/loader.py", "TemporaryDirectory"): "where a damaged wheel does no harm",
    ("backend/loader.py", "NamedTemporaryFile"): "the copy of the native module that is loaded on Windows",
    ("backend/loader.py", "unlink"): "such a copy of a former version",
    ("backend/loader.py", "mkdir"): "the folder of these copies",
    ("operators/deformer/check.py", "NamedTemporaryFile"): "the report of a check, a new file",
    ("session/datablocks/shapes/shapes.py", "unlink"): "an object from a collection; no file is removed",
    ("core/methods/__init__.py", "import_module"): "the modules of its own folder, which are the registry",
}


def security_offences(root: Path) -> list[str]:
    found = []
    for path in files(root, "addon", ".py"):
        name = path.relative_to(root / "addon").as_posix()
        tree = ast.parse(path.read_text(encoding="utf-8"))
        suspects = [*_suspects(tree), *(() if name.startswith("bake/") else _writers(tree))]
        for line, what in suspects:
            if (name, what.split()[-1]) not in ALLOWED:
                found.append(f"addon/{name}:{line}: {what}")
    return found


def _suspects(tree: ast.AST) -> Iterator[tuple[int, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, f"imports {a.name}") for a in node.names if _root(a.name) in MODULES)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and _root(node.module or "") in MODULES:
            yield node.lineno, f"imports {node.module}"
        elif isinstance(node, ast.Name) and node.id in CALLS:
            yield node.lineno, f"names {node.id}"
        elif isinstance(node, ast.Attribute):
            yield from _attribute(node)


def _attribute(node: ast.Attribute) -> Iterator[tuple[int, str]]:
    above = node.value
    if node.attr in ATTRIBUTES:
        yield node.lineno, f"uses {node.attr}"
    if node.attr in OPERATORS and isinstance(above, ast.Attribute) and above.attr == "ops":
        yield node.lineno, f"calls bpy.ops.{node.attr}"
    if isinstance(above, ast.Name) and (above.id, node.attr) in OF_MODULES:
        yield node.lineno, f"uses {above.id}.{node.attr}"  # NumPy's files hold pickles


def _writers(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Only the bakes write files, where ``bake/paths.py`` lets them."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id in OPENING:
            yield node.lineno, f"names {node.id}"
        elif isinstance(node, ast.Attribute) and node.attr in WRITING:
            yield node.lineno, f"uses {node.attr}"


def _root(module: str) -> str:
    return module.partition(".")[0]
