# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators: each checks the context, calls one function of api, and says what went wrong."""

from types import ModuleType


def _modules() -> tuple[ModuleType, ...]:
    from . import (
        bake,
        groups,
        handles,
        job,
        mesh_cache,
        pins,
        pose,
        pose_undo,
        poses,
        poses_blend,
        pull,
        pull_tool,
        solve,
        stiffness,
    )
    from . import select as select_unheld

    on_groups = (pins, handles, stiffness, groups, select_unheld)
    on_poses = (bake, mesh_cache, poses, poses_blend)
    return (*on_groups, pose_undo, pose, pull_tool, pull, solve, *on_poses, job)


def register() -> None:
    for module in _modules():
        module.register()


def unregister() -> None:
    for module in reversed(_modules()):
        module.unregister()
