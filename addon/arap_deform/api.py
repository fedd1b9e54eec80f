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

Errors: ``ValueError`` where the scene or an argument is wrong, ``RuntimeError`` where the solver or the module is, or
where something else has the mesh for itself just now: a posing act, or the job of a solve, a bake or an export;
``Cancelled`` (a RuntimeError) where ``progress`` returned False; then everything is as it was before the call. Each
message is one sentence that says what to do.

Binds, and Solve in the panel, run in a thread. Before Blender 5.1 an operator under ``bpy.context.temp_override`` can
crash Blender meanwhile: call ``wait_for_binds()`` first.

``progress`` is called with the fraction done, 0 to 1; it stops the call by returning False.
"""

from .bake.cache import MeshCacheJob, add_mesh_cache_modifier, begin_mesh_cache, export_mesh_cache
from .bake.keys import BakeEstimate, BakeJob, bake_animation, begin_bake, estimate_bake
from .bake.shapes_job import ShapesJob
from .core.job import Job, run_job
from .core.native import problem as native_problem
from .core.session import Cancelled, Session
from .core.session_data import Readout
from .core.sessions import SessionInput
from .core.worker import wait_for_binds
from .follow.update import (
    adopt_session,
    build_session,
    check_live,
    end_session,
    prepare_session,
    readout,
    rebuild_session,
    session_input,
    sync_session,
    update_pose,
)
from .pose.result import PoseState, apply_pose_as_rest, bake_pose, capture_state, reset_pose, restore_state
from .pose.solve import SolveJob, begin_solve, solve
from .poses.keys import PoseKeysJob, begin_pose_keys, poses_to_keys
from .poses.library import NOW, REST, Placement, apply_pose, blend_poses, delete_pose, mirror_pose, store_pose
from .scene.handle_motion import handle_matrices
from .scene.placing import reset_handles
from .setup.handles import (
    add_handle,
    add_handle_for,
    add_handles_for,
    handle_problem,
    remove_handle,
    set_handle_group,
    set_handle_target,
    update_handle_display,
)
from .setup.pins import add_pin, add_pin_group, remove_pin
from .setup.stiffness import add_rigid, add_stiffness, add_stiffness_group, remove_stiffness, soften_group

__all__ = [
    "NOW",
    "REST",
    "BakeEstimate",
    "BakeJob",
    "Cancelled",
    "Job",
    "MeshCacheJob",
    "Placement",
    "PoseKeysJob",
    "PoseState",
    "Readout",
    "Session",
    "SessionInput",
    "ShapesJob",
    "SolveJob",
    "add_handle",
    "add_handle_for",
    "add_handles_for",
    "add_mesh_cache_modifier",
    "add_pin",
    "add_pin_group",
    "add_rigid",
    "add_stiffness",
    "add_stiffness_group",
    "adopt_session",
    "apply_pose",
    "apply_pose_as_rest",
    "bake_animation",
    "bake_pose",
    "begin_bake",
    "begin_mesh_cache",
    "begin_pose_keys",
    "begin_solve",
    "blend_poses",
    "build_session",
    "capture_state",
    "check_live",
    "delete_pose",
    "end_session",
    "estimate_bake",
    "export_mesh_cache",
    "handle_matrices",
    "handle_problem",
    "mirror_pose",
    "native_problem",
    "poses_to_keys",
    "prepare_session",
    "readout",
    "rebuild_session",
    "remove_handle",
    "remove_pin",
    "remove_stiffness",
    "reset_handles",
    "reset_pose",
    "restore_state",
    "run_job",
    "session_input",
    "set_handle_group",
    "set_handle_target",
    "soften_group",
    "solve",
    "store_pose",
    "sync_session",
    "update_handle_display",
    "update_pose",
    "wait_for_binds",
]
