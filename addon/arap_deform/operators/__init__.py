# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators: each checks the context, calls one function of api, and says what went wrong."""

from types import ModuleType


def _modules() -> tuple[ModuleType, ...]:
    from . import bake, groups, handles, pins, pose, pose_undo, pull, pull_tool, solve, stiffness

    return (pins, handles, stiffness, groups, pose_undo, pose, pull_tool, pull, solve, bake)


def register() -> None:
    for module in _modules():
        module.register()


def unregister() -> None:
    for module in reversed(_modules()):
        module.unregister()
