# SPDX-License-Identifier: GPL-3.0-or-later
"""Solving to the end."""

from __future__ import annotations

import bpy

from . import handle_io, live_key, mesh_io, shape_key
from .api_pose import live_problem, part, prepare_session, solve_from_rest, writable_key, write_pose
from .session import Progress
from .session_data import Readout

BIND_SHARE = 0.3  # of the progress that solve() shows, where it has to bind first


def solve(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None, progress: Progress | None = None
) -> Readout:
    """Poses the mesh for the handles where they are now, to convergence, and writes the key.

    Starts from rest with the guess from the handles' rotations: the same file gives the same result.

    Raises:
        As session_input() and build_session(), or ValueError where the key would not show the pose. The mesh stays
        as it was in each case.
    """
    depsgraph = depsgraph or bpy.context.evaluated_depsgraph_get()
    mesh_io.check_mesh(obj)
    shape_key.check_writable(obj)
    existing = live_key.find(obj)
    if existing is not None:
        shape_key.check_shown(obj, existing)
    is_bound = not live_problem(obj, depsgraph, is_thorough=False)
    session = prepare_session(obj, depsgraph, part(progress, 0.0, 0.0 if is_bound else BIND_SHARE))
    result = solve_from_rest(
        session, handle_io.handle_matrices(obj, depsgraph), part(progress, 0.0 if is_bound else BIND_SHARE, 1.0)
    )
    write_pose(obj, writable_key(obj), session, result)
    return result
