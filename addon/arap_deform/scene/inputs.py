# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads what a session is made from: mesh, groups, settings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..core import naming
from ..core.arrays import Floats
from ..core.session_data import SessionSettings
from ..core.session_input import BoneHold, Counts, GroupHold, Hold, MeshSignature, SceneState, SessionInput
from ..core.stiffness import StiffGroup, regions_of, stiffness_of
from ..core.targets import HandleSpec, Segment
from ..props import preferences
from ..props.bounds import all_bounded, bounded
from . import handle_motion, meshes, pose_key, shape_keys

if TYPE_CHECKING:
    from ..props.handles import ArapHandle, ArapPin


LEAST_CUBE_SIZE = 0.1  # percent of the diagonal

# Settings that have the same name and meaning in ``obj.arap`` and for the solver.
SAME_NAMES = (
    "model", "keep_volume", "energy", "weights", "initial_guess", "iterations_per_update", "max_iterations", "accuracy",
)  # fmt: skip


def settings_of(obj: bpy.types.Object) -> SessionSettings:
    """The solver's settings: of ``obj.arap``, the threads of the preferences."""
    settings = obj.arap
    values = all_bounded(settings, (*SAME_NAMES, "cube_size", "rigidity"))
    cube_size, rigidity = values.pop("cube_size"), values.pop("rigidity")
    if cube_size > 0.0:
        cube_size = max(cube_size, LEAST_CUBE_SIZE)
    return SessionSettings(
        **values,
        cube_size=cube_size / 100.0,
        rigidity_radius=rigidity / 100.0,
        threads=preferences.threads(),
        join_seams=settings.join_seams,
        loose_follow=settings.loose_follow,
    )


def spec_of(entry: ArapPin | ArapHandle, weights: Mapping[str, Floats], rest: Floats) -> HandleSpec:
    """What a pin or handle means for the vertices, or for what is inside.

    Args:
        entry: of the lists.
        weights: (n,) of each group, by name.
        rest: (n, 3).
    """
    hold = hold_of(entry)
    if isinstance(hold, BoneHold):
        ends = np.array(hold.ends).reshape(2, 3)
        return HandleSpec(hold.name, np.empty(0, dtype=np.int32), np.empty(0), segment=Segment(ends))
    of_vertices = weights[hold.group]
    vertices = np.flatnonzero(of_vertices > 0.0).astype(np.int32)
    moved, offsets, n = entry.shape
    base = None
    if n == len(rest):
        base = rest.astype(np.float32)
        base[moved] += offsets
    return HandleSpec(hold.group, vertices, of_vertices[vertices], hold.is_exact, base, hold.reach)


def read_state(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph,
    stretch: Floats,
    key_name: str,
    rest: Floats | None = None,
) -> SceneState:
    """What a frame compares with the session.

    Args:
        obj: a mesh that can be posed.
        depsgraph: for the place of a mirror object.
        stretch: (3, 3) of its evaluated matrix.
        key_name: the shape key that takes the pose.
        rest: (n, 3) the mesh at rest; None: it is read if there is a Mirror modifier.
    """
    return SceneState(
        object_name=obj.name,
        counts=counts_of(obj),
        stretch=stretch,
        settings=settings_of(obj),
        holds=enabled_holds(obj),
        stiff_groups=enabled_stiffness(obj),
        key_name=key_name,
        mirrors=meshes.read_mirrors(obj, depsgraph, stretch, rest),
    )


def read_input(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph,
    *,
    use_nodes: bool | None = None,
    needs_holds: bool = True,
) -> SessionInput:
    """Reads mesh, groups and settings. Main thread only.

    Args:
        depsgraph: for its scale.
        use_nodes: see versions.read_group_weights().
        needs_holds: refuse a mesh without pins and handles.

    Raises:
        ValueError: not a mesh, in Edit Mode, linked or shared data, absolute keys, singular scale, a pin or handle
            without its group or object, a handle whose group has no weights, nothing pinned or handled.
    """
    meshes.check_mesh(obj)
    mesh = meshes.read_mesh(obj)
    stretch = meshes.read_stretch(obj, depsgraph)
    state = read_state(obj, depsgraph, stretch, pose_key.name_of(obj), mesh.rest_positions)
    if found := problems_of(obj, depsgraph, needs_holds=needs_holds):
        raise ValueError(naming.sentences(found))
    wanted = sorted({*groups_of(state.holds), *(entry.group for entry in state.stiff_groups)})
    weights = meshes.read_weights(obj, wanted, use_nodes=use_nodes)
    if found := _unweighted(obj, weights):
        raise ValueError(naming.sentences(found))
    specs = tuple(spec_of(entry, weights, mesh.rest_positions) for entry in enabled_entries(obj))
    stiffness = stiffness_of(state.stiff_groups, weights)
    regions = regions_of(state.stiff_groups, weights, mesh)
    return SessionInput(
        **vars(state),
        mesh=mesh,
        specs=specs,
        signature=MeshSignature.of(mesh, (stiffness, regions)),
        stiffness=stiffness,
        rigid_regions=regions,
    )


def problems_of(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, *, needs_holds: bool = True) -> list[str]:
    """Every reason why a mesh cannot be posed as it is now, a sentence each. Whatever poses it asks here, before work.

    Args:
        obj: a mesh that meshes.check_mesh() accepts, with a scale. Its weights are not looked at.
        needs_holds: see read_input().
    """
    checks = (shape_keys.check_writable, pose_key.check_name)
    found = [reason for check in checks if (reason := _reason_of(check, obj))]
    found += handle_motion.problems(obj, depsgraph)
    if needs_holds and not enabled_entries(obj):
        found.append(f"Nothing holds or moves '{obj.name}': add a pin or a handle")
    return found + _stiffness_problems(obj)


def _reason_of(check: Callable[[bpy.types.Object], None], obj: bpy.types.Object) -> str:
    try:
        check(obj)
    except ValueError as error:
        return str(error)
    return ""


def _unweighted(obj: bpy.types.Object, weights: dict[str, Floats]) -> list[str]:
    """Of each enabled handle whose group has no weights, a sentence that says so."""
    with_group = (h for h in obj.arap.handles if h.is_enabled and not h.is_bone_alone)
    return [handle_motion.no_weights(obj, handle) for handle in with_group if not weights[handle.vertex_group].any()]


def counts_of(obj: bpy.types.Object) -> Counts:
    """Vertices, edges, corners, faces."""
    mesh = obj.data
    return len(mesh.vertices), len(mesh.edges), len(mesh.loops), len(mesh.polygons)


def enabled_entries(obj: bpy.types.Object) -> list[ArapPin | ArapHandle]:
    """The enabled pins, then the enabled handles: the order of the session's handles."""
    return [entry for entry in (*obj.arap.pins, *obj.arap.handles) if entry.is_enabled]


def hold_of(entry: ArapPin | ArapHandle) -> Hold:
    if not hasattr(entry, "vertex_group"):
        return GroupHold(entry.name, shape_id=entry.shape_id)
    if entry.is_bone_alone:
        return BoneHold(entry.name, tuple(handle_motion.bone_ends(entry).ravel().tolist()))
    return GroupHold(entry.vertex_group, entry.is_exact, bounded(entry, "reach"), entry.shape_id)


def groups_of(holds: Iterable[Hold]) -> set[str]:
    """The vertex groups of those that have one."""
    return {hold.group for hold in holds if isinstance(hold, GroupHold)}


def has_group(obj: bpy.types.Object, entry: ArapPin | ArapHandle) -> bool:
    """Whether what an entry holds is there: its vertex group, or its bone without one."""
    hold = hold_of(entry)
    return isinstance(hold, BoneHold) or hold.group in obj.vertex_groups


def enabled_holds(obj: bpy.types.Object) -> tuple[Hold, ...]:
    """Of enabled_entries()."""
    return tuple(hold_of(entry) for entry in enabled_entries(obj))


def enabled_stiffness(obj: bpy.types.Object) -> tuple[StiffGroup, ...]:
    """The enabled entries of the list Stiffness."""
    return tuple(
        StiffGroup(entry.name, bounded(entry, "factor"), entry.is_rigid, entry.is_one_body)
        for entry in obj.arap.stiffness
        if entry.is_enabled
    )


def _stiffness_problems(obj: bpy.types.Object) -> list[str]:
    """Of each enabled entry without a vertex group, a sentence that says so."""
    return [
        f"Stiffness '{entry.group}' of '{obj.name}': there is no vertex group of that name; "
        "choose one or remove it from the list"
        for entry in enabled_stiffness(obj)
        if entry.group not in obj.vertex_groups
    ]
