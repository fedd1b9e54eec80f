# SPDX-License-Identifier: GPL-3.0-or-later
"""What a session is made from, read from the scene: mesh, groups, settings."""

from __future__ import annotations

import bpy
import numpy as np

from ..core.arrays import Floats
from ..core.session_data import SessionSettings
from ..core.sessions import Counts, Hold, MeshSignature, SessionInput
from ..core.stiffness import StiffGroup, regions_of, stiffness_of
from ..core.targets import HandleSpec
from ..props import preferences
from . import handle_motion, meshes, pose_key, shape_keys


def settings_of(obj: bpy.types.Object) -> SessionSettings:
    """The solver's settings: of ``obj.arap``, the threads of the preferences."""
    settings = obj.arap
    return SessionSettings(
        energy=settings.energy,
        rigidity_radius=settings.rigidity / 100.0,
        weights=settings.weights,
        initial_guess=settings.initial_guess,
        iterations_per_update=settings.iterations_per_update,
        max_iterations=settings.max_iterations,
        accuracy=settings.accuracy,
        threads=preferences.threads(),
        join_seams=settings.join_seams,
    )


def spec_of(hold: Hold, weights: Floats) -> HandleSpec:
    """What is held of a group with these (n,) weights."""
    vertices = np.flatnonzero(weights > 0.0).astype(np.int32)
    name, is_exact = hold
    return HandleSpec(name, vertices, weights[vertices], is_exact)


def read_input(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph,
    *,
    use_nodes: bool | None = None,
    needs_holds: bool = True,
) -> SessionInput:
    """As api.session_input().

    Args:
        obj: the mesh.
        depsgraph: for its scale.
        use_nodes: see versions.read_group_weights().
        needs_holds: refuse a mesh without pins and handles.
    """
    meshes.check_mesh(obj)
    shape_keys.check_writable(obj)
    pose_key.check_name(obj)
    handle_motion.check_handles(obj, depsgraph)
    holds = handle_motion.enabled_holds(obj)
    if needs_holds and not holds:
        raise ValueError(f"Nothing holds or moves '{obj.name}': add a pin or a handle")
    check_stiffness(obj)
    stiff_groups = enabled_stiffness(obj)
    wanted = sorted({*(group for group, _ in holds), *(entry.group for entry in stiff_groups)})
    weights = meshes.read_weights(obj, wanted, use_nodes=use_nodes)
    _check_handle_weights(obj, weights)
    mesh = meshes.read_mesh(obj)
    stiffness, regions = stiffness_of(stiff_groups, weights), regions_of(stiff_groups, weights, mesh)
    return SessionInput(
        object_name=obj.name,
        mesh=mesh,
        stretch=meshes.read_stretch(obj, depsgraph),
        settings=settings_of(obj),
        specs=tuple(spec_of(hold, weights[hold[0]]) for hold in holds),
        holds=holds,
        signature=MeshSignature.of(counts_of(obj), mesh, (stiffness, regions)),
        stiff_groups=stiff_groups,
        key_name=pose_key.name_of(obj),
        stiffness=stiffness,
        rigid_regions=regions,
    )


def _check_handle_weights(obj: bpy.types.Object, weights: dict[str, Floats]) -> None:
    for handle in obj.arap.handles:
        if handle.is_enabled and not weights[handle.vertex_group].any():
            raise ValueError(handle_motion.no_weights(obj, handle))


def counts_of(obj: bpy.types.Object) -> Counts:
    """Vertices, edges, corners, faces."""
    mesh = obj.data
    return len(mesh.vertices), len(mesh.edges), len(mesh.loops), len(mesh.polygons)


def enabled_stiffness(obj: bpy.types.Object) -> tuple[StiffGroup, ...]:
    """What the list says, without what is switched off."""
    return tuple(
        StiffGroup(entry.name, entry.factor, entry.is_rigid, entry.is_one_body)
        for entry in obj.arap.stiffness
        if entry.is_enabled
    )


def check_stiffness(obj: bpy.types.Object) -> None:
    """Raises ValueError where an enabled entry has no vertex group."""
    for entry in enabled_stiffness(obj):
        if entry.group not in obj.vertex_groups:
            raise ValueError(
                f"Stiffness '{entry.group}' of '{obj.name}': there is no vertex group of that name; "
                "choose one or remove it from the list"
            )
