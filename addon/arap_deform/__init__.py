# SPDX-License-Identifier: GPL-3.0-or-later
"""ARAP Deform: poses a mesh as rigidly as possible with handles, live, and bakes the poses to shape keys.

Modules are imported in register(), so that those without bpy (session, the interaction) load in a plain Python too.
"""

import importlib
import sys
from types import ModuleType

# The modules that give something to Blender, in this order; see scene/registration.
MODULES = {
    "props": ("pull", "preferences", "controls", "poses", "attach", "object"),
    "scene": ("ui_cache", "redraw"),
    "engine": ("applied",),
    "ui": ("panels", "edit_mode", "waiting", "esc"),
    "setup": (
        "control_changes",
        "made_objects",
        "chosen",
        "list_operators",
        "bone_operators",
        "select_operators",
        "group_operators",
        "panels",
    ),
    "follow": ("runs",),
    "show": ("overlay", "panel"),
    "pose": ("undo", "operators"),
    "attach": ("sync_handlers", "operators", "stand_in_operators", "cage_operators", "panel"),
    "pull": ("tool", "operators", "draw"),
    "bake": ("operators", "panel"),
    "poses": ("library", "operators", "blend_operator", "panel"),
    "tab": ("pose_panel", "advanced_panel", "menus"),
}


def _module(name: str) -> ModuleType:
    return importlib.import_module(f"{__name__}.{name}")


def _modules() -> list[ModuleType]:
    in_rooms = [_module(f"{room}.{name}") for room, names in MODULES.items() for name in names]
    return [*in_rooms, _module("handlers"), _module("cli")]


def register() -> None:
    for module in _modules():
        _module("scene.registration").register(module)


def unregister() -> None:
    for module in reversed(_modules()):
        _module("scene.registration").unregister(module)
    # Blender reloads this file alone when a new version is installed: the rest must be imported again.
    for name in [name for name in sys.modules if name.startswith(f"{__name__}.")]:
        del sys.modules[name]
        # "from . import x" takes the package's attribute before it looks for a module: the old one would come back.
        globals().pop(name.removeprefix(f"{__name__}."), None)
