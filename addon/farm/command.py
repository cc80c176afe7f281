# SPDX-License-Identifier: GPL-3.0-or-later
"""Starts the atom where Blender has no ``--command``: before 4.2, and as a Python module.

    blender --background --python command.py -- bake SHOT.blend WORDS...
    python command.py join DIR WORDS...

The status is that of the atom. It is 3 if the add-on of this folder cannot be enabled.
"""

import json
import os
import sys

import bpy

# isort: split
import addon_utils  # comes with bpy, not before it

FOLDER = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))


def enabled():
    """The room of the add-on that this file belongs to, or None."""
    for module in addon_utils.modules():
        if os.path.dirname(os.path.realpath(module.__file__)) == FOLDER:
            name = module.__name__
            is_on = getattr(sys.modules.get(name), "__addon_enabled__", False) or addon_utils.enable(name)
            return sys.modules.get(f"{name}.farm.atom") if is_on else None
    return None


def main(words):
    atom = enabled()
    if atom is None:
        message = f"The add-on in {FOLDER} is not installed in this Blender, or cannot be enabled"
        print(json.dumps({"sinew": "error", "message": message, "code": 3}), flush=True)
        return 3
    return atom.run(words[0] if words else "", words[1:])


is_module = not bpy.app.binary_path
after = sys.argv.index("--") + 1 if "--" in sys.argv else 1 if is_module else len(sys.argv)
status = main(sys.argv[after:])
sys.stdout.flush()
if is_module:
    os._exit(status)  # Blender as a module may hang or crash while it ends
sys.exit(status)
