# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads what a session is made from: mesh, groups, settings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..core import naming
from ..core.arrays import Floats
from ..core.session_input import BoneConstraint, Constraint, MeshSignature, SessionInput, VertexConstraint
from ..core.stiffness import regions_of, stiffness_of
from ..core.targets import HandleSpec, Segment
from . import handle_motion, meshes, pose_key, shape_keys
from .snapshot import Snapshot, constraints_of, stiff_groups_of

if TYPE_CHECKING:
    from ..props.controls import ArapControl


def spec_of(control: ArapControl, weights: Mapping[str, Floats], rest: Floats) -> HandleSpec:
    """What a pin or handle means for the vertices, or for what is inside.

    Args:
        weights: (n,) of each group, by name.
        rest: (n, 3).
    """
    hold = constraints_of([control])[0]
    if isinstance(hold, BoneConstraint):
        ends = np.array(hold.ends).reshape(2, 3)
        return HandleSpec(hold.name, np.empty(0, dtype=np.int32), np.empty(0), segment=Segment(ends))
    of_vertices = weights[hold.group]
    vertices = np.flatnonzero(of_vertices > 0.0).astype(np.int32)
    moved, offsets = control.base
    base = None
    if len(moved):
        base = rest.astype(np.float32)
        base[moved] += offsets
    return HandleSpec(hold.group, vertices, of_vertices[vertices], hold.use_exact, base, hold.reach)


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
    state = Snapshot.read(obj, depsgraph, mesh.rest_positions).state
    if found := problems_of(obj, depsgraph, needs_holds=needs_holds):
        raise ValueError(naming.sentences(found))
    wanted = sorted({*groups_of(state.constraints), *(entry.group for entry in state.stiff_groups)})
    weights = meshes.read_weights(obj, wanted, use_nodes=use_nodes)
    if found := _unweighted(obj, weights):
        raise ValueError(naming.sentences(found))
    specs = tuple(spec_of(control, weights, mesh.rest_positions) for control in handle_motion.enabled_controls(obj))
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
    if needs_holds and not handle_motion.enabled_controls(obj):
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
    with_group = (h for h in obj.arap.handles if h.is_enabled and h.kind == "handle")
    return [handle_motion.no_weights(obj, handle) for handle in with_group if not weights[handle.vertex_group].any()]


def groups_of(holds: Iterable[Constraint]) -> set[str]:
    """The vertex groups of those that have one."""
    return {hold.group for hold in holds if isinstance(hold, VertexConstraint)}


def has_group(obj: bpy.types.Object, control: ArapControl) -> bool:
    """Whether what a control holds is there: its vertex group. A bone needs none."""
    return control.kind == "bone" or control.vertex_group in obj.vertex_groups


def _stiffness_problems(obj: bpy.types.Object) -> list[str]:
    """Of each enabled entry without a vertex group, a sentence that says so."""
    return [
        f"Stiffness '{entry.group}' of '{obj.name}': there is no vertex group of that name; "
        "choose one or remove it from the list"
        for entry in stiff_groups_of(obj)
        if entry.group not in obj.vertex_groups
    ]
