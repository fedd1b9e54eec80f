# SPDX-License-Identifier: GPL-3.0-or-later
"""ARAP Deform: poses a mesh as rigidly as possible with handles, live, and bakes the poses to shape keys.

Modules are imported in register(), so that those without bpy (session, the posing act) load in a plain Python too.
"""

import sys
from types import ModuleType

bl_info = {
    "name": "ARAP Deform",
    "author": "ARAP Deform contributors",
    "description": "Pose a mesh with handles, as rigidly as possible, and bake the poses to shape keys",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > ARAP",
    "category": "Animation",
}


def _modules() -> tuple[ModuleType, ...]:
    from . import (
        bake_panel,
        cli,
        first_pose_panel,
        handlers,
        handles_panel,
        live,
        live_panel,
        menus,
        operators,
        overlay,
        overlay_panel,
        panels,
        pins_panel,
        pose_panel,
        poses_panel,
        preferences,
        properties,
        pull_draw,
        settings_panel,
        stiffness_panel,
    )

    acts = (handlers, operators, live, pull_draw, overlay)
    on_mesh = (first_pose_panel, pins_panel, handles_panel, stiffness_panel, pose_panel)
    on_result = (poses_panel, live_panel, bake_panel, overlay_panel, settings_panel)
    return (preferences, properties, *acts, panels, *on_mesh, *on_result, menus, cli)


def register() -> None:
    for module in _modules():
        module.register()


def unregister() -> None:
    for module in reversed(_modules()):
        module.unregister()
    # Blender reloads this file alone when a new version is installed: the rest must be imported anew.
    for name in [name for name in sys.modules if name.startswith(f"{__name__}.")]:
        del sys.modules[name]
        # "from . import x" takes the package's attribute before it looks for a module: the old one would come back.
        globals().pop(name.removeprefix(f"{__name__}."), None)
