# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs in a Blender with Sinew: writes what LLM.md, the page for those who write scripts, lists of methods,
operators, properties, errors and the native module."""

import importlib
import inspect
import os
import re
from collections.abc import Callable, Iterator
from operator import attrgetter
from pathlib import Path

import bpy

PAGE = Path(__file__).resolve().parents[3] / "LLM.md"
MARKS = "<!-- reference: written by tools/describe_methods -->", "<!-- end of reference -->"
IN_FULL = "SurfaceMesh.__init__ SurfaceMethod.set_handles SurfaceMethod.solve SpaceMethod.bind"
IN_FULL += " SpaceMethod.warp automatic_cage deform warp"


def page_of(text: str, room: Callable) -> str:
    """The page with a new reference. ``room`` gives modules of the add-on."""
    native, (before, _old, after) = room("backend").availability().module, re.split("|".join(MARKS), text)
    parts = [*methods(room, native), *operators(), *properties(room), *errors(room, native)]
    return "\n".join((f"{before}{MARKS[0]}", *parts, *functions(native), f"{MARKS[1]}{after}"))


def properties_of(struct: bpy.types.Struct) -> Iterator[str]:
    """Those that scripts may set or read: neither what Sinew notes for itself, nor the groups of methods."""
    for prop in struct.properties:
        kind = getattr(getattr(prop, "fixed_type", None), "identifier", "")
        of_blender = prop.identifier == "rna_type" or prop.description.startswith("Unique name used in")
        if prop.is_hidden or of_blender or kind.startswith("SINEW_PG_"):
            continue
        value = f"a list of {kind}" if prop.type == "COLLECTION" else kind
        if prop.identifier in ("method", "base"):  # among which depends on what is active
            value = "the id of a method"
        elif prop.type == "ENUM":
            value = f"{prop.default!r} of {', '.join(item.identifier for item in prop.enum_items)}"
        elif getattr(prop, "is_array", False):
            value = f"({', '.join(f'{number:.6g}' for number in prop.default_array)})"
        elif prop.type in ("FLOAT", "INT"):
            ends = (("from", prop.hard_min), ("to", prop.hard_max))
            limits = (f" {word} {end:.6g}" for word, end in ends if abs(end) < 1e6)  # else there is none
            value = f"{prop.default:.6g}{''.join(limits)}"
        yield f"- `{prop.identifier}` ({value or repr(prop.default)}): {prop.description or prop.name}."


def signature(name: str, function: object) -> str:
    """What a function of the module takes, without types."""
    line = inspect.getdoc(function).splitlines()[0]
    bare = re.sub(r"\[[^\[\]]*(?:\[[^\[\]]*\])*[^\[\]]*\]", "", line[line.find("(") + 1 : line.rfind(")")])
    return f"{name}({re.sub('^self(, )?', '', re.sub(': [^=,]*', '', bare).replace('= ', '='))})"


def methods(room: Callable, native) -> Iterator[str]:
    yield from ("## Tasks and methods", "")
    for task in room("core.tasks").TASKS:
        known = ", ".join(f"`{method}`" for method in task.methods)
        yield f"- task `{task.id}`, {task.label}: {task.purpose}. By {known or 'none'}."
    for row in room("core.methods").METHODS:
        yield from ("", f"### {row.id}", "", f"{row.label}: {row.known_as} [{row.paper}]. {row.summary}.")
        yield f"Fails: {row.fails}. Moved by: {row.control.value}. Needs: {row.needs or 'points'}."
        yield from (f"Python: `{signature(row.native, getattr(native, row.native).__init__)}`.", "")
        yield from properties_of(room("properties.parameters").GROUPS[row.id].bl_rna)


def operators() -> Iterator[str]:
    yield from ("", "## Operators")
    for name in sorted(dir(bpy.ops.sinew)):
        if getattr(getattr(bpy.types, f"SINEW_OT_{name}"), "bl_options", None) != {"INTERNAL"}:
            struct = getattr(bpy.ops.sinew, name).get_rna_type()
            yield from (
                "",
                f"`bpy.ops.sinew.{name}`, {struct.name}: {struct.description}.",
                "",
                *properties_of(struct),
            )


def properties(room: Callable) -> Iterator[str]:
    deformer = room("properties").SinewDeformer.bl_rna
    yield from ("", "## Properties", "", "`deformer`:", "", *properties_of(deformer))
    for name in ("handles", "controls", "keys", "bake"):
        yield from ("", f"`deformer.{name}`:", "", *properties_of(deformer.properties[name].fixed_type))


def errors(room: Callable, native) -> Iterator[str]:
    yield from ("", "## Errors", "")
    for name, value in vars(native).items():
        if inspect.isclass(value) and issubclass(value, native.Error):
            yield f"- `sn.{name}`: {' '.join(vars(value)['__doc__'].split())}"
    calls: dict[str, dict[str, None]] = {}
    for button in room("ui.status_box").remedies().values():
        words = ", ".join(f"{key}={value!r}" for key, value in button.properties if key != "module")
        calls.setdefault(button.text, {})[f"`bpy.ops.{button.operator}({words})`"] = None
    for text, found in calls.items():
        yield f"- **{text}** in a message below is {' or '.join(found)}."
    troubles = PAGE.with_name("docs").joinpath("manual/troubles.md").read_text(encoding="utf-8")
    for says, remedy in re.findall(r"^\| (.*) \| .* \| (.*) \|$", troubles, re.MULTILINE)[1:]:
        yield re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", f"- *{says}*: {remedy}.")


def functions(native) -> Iterator[str]:
    yield from ("", "## The module", "")
    for name, function in sorted(vars(native).items()):
        if inspect.isroutine(function):
            text = inspect.getdoc(function).partition("\n")[2].strip()
            sentence = re.split(r"(?<!Eq)\.(?:\s|$)|\n\n", text)[0]
            yield f"- `sn.{signature(name, function)}`: {' '.join(sentence.split())}."
    for path in IN_FULL.split():
        thing = attrgetter(path)(native)
        yield from ("", f"### {path}", "", "```text", signature(path, thing))
        yield from (inspect.getdoc(thing).partition("\n")[2].rstrip(), "```")


if __name__ == "__main__":
    import addon_utils  # comes with bpy

    addon = os.environ["SINEW_ADDON_MODULE"]
    addon_utils.enable(addon)
    new = page_of(PAGE.read_text(encoding="utf-8"), lambda path: importlib.import_module(f"{addon}.{path}"))
    PAGE.write_text(new, encoding="utf-8")
