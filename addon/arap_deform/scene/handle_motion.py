# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles in the scene to matrices: their motion since rest, and why one cannot work."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import naming
from ..core.arrays import Floats
from ..core.transforms import inverted, transformed
from . import meshes
from .movers import still
from .movers.twice import why_twice

if TYPE_CHECKING:
    from ..props.controls import ArapControl

Made = dict[bpy.types.Object, set[bpy.types.Object]]  # the made empties of the handles of each object

SMALLEST_VOLUME = 1e-24  # of a handle's rest matrix, as its determinant; below, its motion since rest is unknown


def enabled_controls(obj: bpy.types.Object) -> list[ArapControl]:
    """In the order of the list, which is that of the session's handles."""
    return [control for control in obj.arap.controls if control.is_enabled]


def handle_matrices(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> NDArray[np.float64]:
    """(h, 4, 4) float64 object-space motion of each enabled control; the identity for pins.

    (O_now^-1 M_now)(O_rest^-1 M_rest)^-1, of evaluated matrices. The order is that of the session's handles.

    Raises:
        ValueError: a handle's object, bone or group is missing, or its object is not kept up to date by Blender.
    """
    depsgraph = depsgraph or bpy.context.evaluated_depsgraph_get()
    return motions(obj, depsgraph, object_matrix(obj, depsgraph))


def motions(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, world: Floats) -> NDArray[np.float64]:
    """As handle_matrices(), for an object whose evaluated (4, 4) ``world`` matrix has an inverse."""
    if found := problems(obj, depsgraph):
        raise ValueError(naming.sentences(found))
    enabled = enabled_controls(obj)
    moving = [i for i, control in enumerate(enabled) if control.kind != "pin"]
    result = np.tile(np.eye(4), (len(enabled), 1, 1))
    if moving:
        handles = [enabled[i] for i in moving]
        now = np.array([target_matrix(h.target, h.bone, depsgraph) for h in handles])
        rest = np.array([h.rest_matrix[:] for h in handles], dtype=np.float64).reshape(-1, 4, 4)
        inverse = inverted(np.concatenate([world[None], rest]))
        result[moving] = inverse[0] @ now @ inverse[1:]
    return result


def motion_of(handle: ArapControl, depsgraph: bpy.types.Depsgraph, world: Floats) -> Floats:
    """(4, 4) object-space motion of one handle, enabled or not. ``world``: object_matrix() of the mesh."""
    now = target_matrix(handle.target, handle.bone, depsgraph)
    rest = np.array(handle.rest, dtype=np.float64)
    return np.asarray(inverted(world) @ now @ inverted(rest))


def problems(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> list[str]:
    """Why enabled pins and handles, or the object itself, cannot work: a sentence each."""
    if reason := meshes.why_not_evaluated(obj, depsgraph):
        return [reason]
    made: Made = {}
    enabled = enabled_controls(obj)
    return [reason for control in enabled if (reason := problem_of(obj, control, depsgraph, made))]


def problem_of(
    obj: bpy.types.Object, control: ArapControl, depsgraph: bpy.types.Depsgraph, made: Made | None = None
) -> str:
    """Why a pin, handle or bone cannot work, one sentence; '' if it can. ``made``: see other_owner()."""
    kind = control.kind
    reason = "" if kind == "pin" else _why_unmoved(obj, control, depsgraph, made)
    if not reason and kind == "bone":
        if obj.arap.model != "solid":
            reason = "a bone moves what is inside of a solid; choose Model: Solid"
    elif not reason and control.vertex_group not in obj.vertex_groups:
        reason = f"there is no vertex group '{control.vertex_group}'; choose one or remove the {kind}"
    return f"{control.label} of '{obj.name}': {reason}" if reason else ""


def _why_unmoved(obj: bpy.types.Object, handle: ArapControl, depsgraph: bpy.types.Depsgraph, made: Made | None) -> str:
    """Why the object or bone of a handle cannot move it, without the name of the handle."""
    reason = target_problem(
        obj,
        handle.target,
        handle.bone,
        depsgraph,
        is_made=handle.has_made_target,
        needs_bone=handle.kind == "bone",
    )
    if reason:
        return reason
    owner = other_owner(obj, handle, made) if handle.target.parent not in {None, obj} else None
    if owner is not None:
        return f"its empty belongs to '{owner.name}', of which this is a copy; press Copy Handles"
    if not any(handle.rest_matrix):
        return (
            f"'{obj.name}' was scaled to nothing when '{handle.target.name}' was chosen; "
            "give the mesh a scale and choose it again"
        )
    volume = handle.rest.determinant()
    if not math.isfinite(volume):
        return f"its rest place is not a finite one; choose '{handle.target.name}' again"
    if abs(volume) < SMALLEST_VOLUME:
        return f"'{handle.target.name}' was scaled to nothing at rest; give it a scale and choose it again"
    return ""


def other_owner(obj: bpy.types.Object, handle: ArapControl, made: Made | None = None) -> bpy.types.Object | None:
    """The mesh that a made empty belongs to, if that is not ``obj``, which is a copy then; None if it is no other one.

    An empty is a child of the mesh that it was made for. One that the artist has given another parent, and one that was
    chosen by hand, belongs to every mesh that has it as a handle.

    Args:
        made: a dict that starts empty, for a caller who asks of many handles.
    """
    made = {} if made is None else made
    above = handle.target.parent if handle.has_made_target and handle.target is not None else None
    while above is not None and above != obj:
        if above not in made:
            is_mesh = above.type == "MESH" and above.library is None
            made[above] = {h.target for h in above.arap.handles if h.has_made_target} if is_mesh else set()
        if handle.target in made[above]:
            return above
        above = above.parent
    return None


def foreign_handles(obj: bpy.types.Object) -> list[ArapControl]:
    """The handles whose made empty belongs to another mesh, or is in no scene: as after a paste, or if deleted."""
    handles = [handle for handle in obj.arap.handles if handle.has_made_target and handle.target is not None]
    if not handles:
        return []
    in_scenes = {other for scene in bpy.data.scenes for other in scene.objects}
    made: Made = {}
    return [h for h in handles if h.target not in in_scenes or other_owner(obj, h, made) is not None]


def no_weights(obj: bpy.types.Object, handle: ArapControl) -> str:
    return (
        f"{handle.label} of '{obj.name}': vertex group '{handle.vertex_group}' has no weights; "
        "assign vertices to it or remove the handle"
    )


def target_problem(
    obj: bpy.types.Object,
    target: bpy.types.Object | None,
    bone: str,
    depsgraph: bpy.types.Depsgraph,
    *,
    is_made: bool = False,
    needs_bone: bool = False,
) -> str:
    """Why an object, or its bone, cannot be that of a handle.

    ``is_made``: the add-on has made it. ``needs_bone``: the object alone moves nothing.
    """
    if needs_bone and not bone:
        return "it has no bone; choose one or remove it"
    if target is None:
        return "it has no object; choose one or remove the handle"
    if target == obj:
        return f"'{target.name}' is the mesh itself; choose another object"
    if (target.library or target.override_library) and (reason := still.why_missing(target)):
        return reason
    if not meshes.is_evaluated(target, depsgraph):
        if depsgraph.scene.objects.get(target.name) != target:
            if is_made:
                return "its empty is not in the scene; press Copy Handles or remove the handle"
            return f"'{target.name}' is not in the scene; choose another object or remove the handle"
        return (
            f"'{target.name}' is disabled in viewports or excluded from the view layer, so it does not move; "
            "enable it, or hide it with the eye"
        )
    if bone and target.type != "ARMATURE":
        return f"'{target.name}' is not an armature and has no bones; clear the bone"
    if bone and (target.pose is None or bone not in target.pose.bones):
        return f"armature '{target.name}' has no bone '{bone}'; choose another bone"
    return why_twice(obj, target, bone) if obj.modifiers or obj.parent == target else ""


def object_matrix(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Floats:
    meshes.read_stretch(obj, depsgraph)  # refuses what has no inverse
    return meshes.read_matrix(obj, depsgraph)


def target_matrix(target: bpy.types.Object, bone: str, depsgraph: bpy.types.Depsgraph) -> Floats:
    evaluated = target.evaluated_get(depsgraph)
    matrix = np.array(evaluated.matrix_world, dtype=np.float64)
    return matrix @ np.array(evaluated.pose.bones[bone].matrix, dtype=np.float64) if bone else matrix


def bone_ends(handle: ArapControl) -> Floats:
    """(2, 3) head and tail of its bone at rest, object space; zeros if the bone is missing, see problem_of()."""
    is_armature = handle.target is not None and handle.target.type == "ARMATURE"
    bone = handle.target.data.bones.get(handle.bone) if is_armature else None
    if bone is None:
        return np.zeros((2, 3))
    along = np.array([[0.0, 0.0, 0.0], [0.0, bone.length, 0.0]])
    return transformed(np.array(handle.rest, dtype=np.float64), along)


def bone_rest_matrix(armature: bpy.types.Object, bone: str, depsgraph: bpy.types.Depsgraph) -> Floats:
    """(4, 4) world matrix of a bone in the rest position of its armature, where that stands now."""
    in_armature = np.array(armature.data.bones[bone].matrix_local, dtype=np.float64)
    return np.asarray(meshes.read_matrix(armature, depsgraph) @ in_armature)
