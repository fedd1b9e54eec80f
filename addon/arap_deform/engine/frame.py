# SPDX-License-Identifier: GPL-3.0-or-later
"""One frame of a mesh: does its session fit what is seen, and the solve that writes the shape key."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import bpy

from ..core import sessions
from ..core.arrays import Floats
from ..core.session import Session
from ..core.session_data import SolveStats
from ..core.session_input import Constraint, difference, difference_of_scene
from ..core.sessions import Bound
from ..scene import meshes, pose_key, shape_keys
from ..scene.inputs import read_input
from ..scene.snapshot import Snapshot
from . import mesh


def look(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph,
    bound: Bound | None,
    constraints: tuple[Constraint, ...] | None = None,
) -> tuple[Snapshot | None, str]:
    """A snapshot of the mesh, and why a session cannot go on from it, one sentence; '' if it can.

    Args:
        depsgraph: to read matrices from.
        bound: the session.
        constraints: what it must hold; None: what the pins and handles of the object do.
    """
    if bound is None:
        return None, f"'{obj.name}' is not being posed"
    if reason := meshes.why_not_posable(obj):
        return None, reason
    try:
        snapshot = Snapshot.read(obj, depsgraph, bound.inputs.mesh.rest_positions)
    except ValueError as error:
        return None, str(error)
    state = snapshot.state if constraints is None else replace(snapshot.state, constraints=constraints)
    return snapshot, difference_of_scene(bound.inputs, state)


def look_closely(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, bound: Bound, *, use_nodes: bool | None = False
) -> str:
    """As the text of look(), of topology, rest shape and weights, too, which takes milliseconds.

    ``use_nodes``: see versions.read_group_weights().
    """
    try:
        return difference(bound.inputs, read_input(obj, depsgraph, use_nodes=use_nodes))
    except ValueError as error:
        return str(error)


def solve(
    snapshot: Snapshot, bound: Bound, motions: Floats, *, is_from_rest: bool = False, **options: Any
) -> SolveStats:
    """Solves and writes the key, which is made if there is none.

    Args:
        bound: of which look() says nothing.
        motions: (h, 4, 4) object-space motions of all that the session holds.
        is_from_rest: see mesh.solve_from_rest().
        options: of Session.update().

    Raises:
        ValueError: the key would not show the pose; nothing has changed.
    """
    session = bound.session
    session.settings = snapshot.state.settings
    key = pose_key.writable(snapshot.obj, snapshot.key)
    update = mesh.solve_from_rest if is_from_rest else Session.update
    result = update(session, motions, **options)
    write_pose(snapshot.obj, key, session, result, is_frame=True)
    return result


def write_pose(
    obj: bpy.types.Object, key: bpy.types.ShapeKey, session: Session, result: SolveStats, *, is_frame: bool = False
) -> None:
    """Writes the session's positions to the key, shows it, and keeps the stats for the panel.

    ``is_frame``: see hooks.key_written.
    """
    shape_keys.write(obj, key, session.positions, is_frame=is_frame)
    shape_keys.show(key)
    sessions.set_stats(obj.session_uid, result)
