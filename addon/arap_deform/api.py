# SPDX-License-Identifier: GPL-3.0-or-later
"""ARAP Deform for scripts. Every function works on data, with or without a window, and never through selection.

    import bpy
    from arap_deform import api     # as an extension: from bl_ext.user_default.arap_deform import api

    obj = bpy.data.objects["Creature"]
    api.add_pin(obj, range(0, 40), name="Feet")
    tail = api.add_handle(obj, [501, 502, 503], name="Tail")
    tail.target.location.z += 0.5
    print(api.solve(obj))
    api.bake_pose(obj, name="Tail up")

Vertices are indices: a sequence or an integer array. Matrices are world matrices of evaluated objects, so parents,
constraints, drivers and animation count. Objects must be in Object Mode and their mesh must be local and used once.

Errors: ``ValueError`` where the scene or an argument is wrong, ``RuntimeError`` where the solver or the module is,
``Cancelled`` (a RuntimeError) where ``progress`` returned False; then everything is as it was before the call. Each
message is one sentence that says what to do.

``progress`` is called with the fraction done, 0 to 1; it stops the call by returning False.
"""

from .api_bake import BakeEstimate, BakeJob, bake_animation, begin_bake, estimate_bake, run_bake
from .api_handles import (
    add_handle,
    add_handle_for,
    add_handles_for,
    add_pin,
    add_pin_group,
    handle_problem,
    remove_handle,
    remove_pin,
    reset_handles,
    set_handle_group,
    set_handle_target,
    update_handle_display,
)
from .api_pose import (
    adopt_session,
    build_session,
    check_live,
    end_session,
    prepare_session,
    readout,
    rebuild_session,
    session_input,
    solve,
    sync_session,
    update_pose,
)
from .api_result import PoseState, apply_pose_as_rest, bake_pose, capture_state, reset_pose, restore_state
from .api_stiffness import add_rigid, add_stiffness, add_stiffness_group, remove_stiffness, soften_group
from .handle_io import handle_matrices
from .native import problem as native_problem
from .session import Cancelled, Readout, Session
from .sessions import SessionInput

__all__ = [
    "BakeEstimate",
    "BakeJob",
    "Cancelled",
    "PoseState",
    "Readout",
    "Session",
    "SessionInput",
    "add_handle",
    "add_handle_for",
    "add_handles_for",
    "add_pin",
    "add_pin_group",
    "add_rigid",
    "add_stiffness",
    "add_stiffness_group",
    "adopt_session",
    "apply_pose_as_rest",
    "bake_animation",
    "bake_pose",
    "begin_bake",
    "build_session",
    "capture_state",
    "check_live",
    "end_session",
    "estimate_bake",
    "handle_matrices",
    "handle_problem",
    "native_problem",
    "prepare_session",
    "readout",
    "rebuild_session",
    "remove_handle",
    "remove_pin",
    "remove_stiffness",
    "reset_handles",
    "reset_pose",
    "restore_state",
    "run_bake",
    "session_input",
    "set_handle_group",
    "set_handle_target",
    "soften_group",
    "solve",
    "sync_session",
    "update_handle_display",
    "update_pose",
]
