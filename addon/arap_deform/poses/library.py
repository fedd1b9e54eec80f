# SPDX-License-Identifier: GPL-3.0-or-later
"""Stored poses of an object's handles: storing, applying, blending, mirroring, deleting. None of these solves.

A pose has the motion of each handle since rest, relative to the mesh object. This is the motion that the solver takes,
so a handle that has got another empty or bone has the same effect on the mesh. A handle is known by a number, which it
gets when it is first stored, so it may be renamed. If it was deleted, a new handle of its name takes its place.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..core import naming
from ..core.arrays import Floats
from ..core.patches import diagonal_of
from ..props import hooks
from ..scene import handle_motion, meshes, placing
from . import blend

if TYPE_CHECKING:
    from ..props.poses import ArapStoredPose

PARTNER_REACH = 0.01  # largest distance of a partner from the mirrored place, as a fraction of the diagonal

Motions = dict[int, Floats]  # (4, 4) object-space motions since rest, by index of the handle


class Standing(Enum):
    """Poses that need not be stored."""

    REST = "the rest pose"
    NOW = "the present pose"


REST, NOW = Standing.REST, Standing.NOW

PoseRef = str | Standing  # a stored pose by its name, or REST or NOW


@dataclass(frozen=True)
class Placement:
    """Names of the handles that are not in the pose that was applied.

    Attributes:
        gone: stored handles that were deleted or cannot be moved.
        others: handles that the pose does not have; they stay.
        held: handles that animation, a constraint, a driver or a sheared parent holds elsewhere.
    """

    gone: tuple[str, ...] = ()
    others: tuple[str, ...] = ()
    held: tuple[str, ...] = ()

    def __str__(self) -> str:
        """One sentence; '' if all handles are in the pose."""
        parts = [
            part.format(", ".join(names))
            for part, names in (
                ("deleted or unusable: {}", self.gone),
                ("not in the pose, so they stay: {}", self.others),
                ("held by animation, a constraint, a driver or a sheared parent: {}", self.held),
            )
            if names
        ]
        return f"Not every handle is in the pose; {'; '.join(parts)}" if parts else ""


def find(obj: bpy.types.Object, name: str) -> ArapStoredPose:
    """Raises ValueError if there is no such pose."""
    pose: ArapStoredPose | None = obj.arap.poses.get(name)
    if pose is None:
        raise ValueError(f"'{obj.name}' has no stored pose '{name}': choose one of the list")
    return pose


def store_pose(obj: bpy.types.Object, name: str = "Pose", *, replace: bool = False) -> ArapStoredPose:
    """Stores the evaluated places of all handles, enabled or not.

    Args:
        name: of the pose; it gets a number if another pose has it.
        replace: replaces the pose of that name, if there is one.

    Raises:
        ValueError: no name, no handle that works, or the object is of another file.
    """
    meshes.check_mesh(obj)
    meshes.check_local(obj)
    if not name:
        raise ValueError("The pose needs a name: type one, for example Smile")
    motions = _motions_now(obj)
    if not motions:
        raise ValueError(f"'{obj.name}' has no handle that works: add one, or repair the ones it has")
    poses = obj.arap.poses
    pose = poses.get(name) if replace else None
    return _write(obj, poses.add() if pose is None else pose, name, motions)


def delete_pose(obj: bpy.types.Object, name: str) -> None:
    """Deletes a pose; the shape key that was made of it stays."""
    find(obj, name)
    meshes.check_local(obj)
    poses = obj.arap.poses
    poses.remove(poses.find(name))
    obj.arap.active_pose_index = max(0, min(obj.arap.active_pose_index, len(poses) - 1))


def apply_pose(obj: bpy.types.Object, name: str) -> Placement:
    """Moves the handles to their places in the pose, relative to the mesh. Does not solve."""
    return blend_poses(obj, REST, name, 1.0)


def blend_poses(obj: bpy.types.Object, first: PoseRef, second: PoseRef, factor: float) -> Placement:
    """Moves the handles to places between two poses, see poses.blend. Does not solve.

    Args:
        first, second: names of stored poses, REST or NOW.
        factor: 0 for the first pose, 1 for the second; may be a little beyond.

    Raises:
        ValueError: no such pose, or a handle is flat or turned inside out in one of them; no handle has moved.
    """
    meshes.check_mesh(obj)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    first_motions, first_gone = motions_of(obj, first)
    second_motions, second_gone = motions_of(obj, second)
    indices = sorted(first_motions.keys() & second_motions.keys())
    motions = _between(obj, first_motions, second_motions, indices, factor, depsgraph)
    held = placing.place_handles(obj, motions)
    others = [obj.arap.controls[i].name for i in placing.working_handles(obj, depsgraph) if i not in motions]
    return Placement(tuple(dict.fromkeys((*first_gone, *second_gone))), tuple(others), tuple(held))


def mirror_pose(obj: bpy.types.Object, name: str, axis: int = 0) -> ArapStoredPose:
    """Stores the mirror image of a pose in the object's plane ``axis`` = 0; for partners see blend.partners().

    If the name has a side (Out.L), the new pose has the name with the other side (Out.R).

    Raises:
        ValueError: no such pose, a handle of it has no partner, or the object is of another file.
    """
    meshes.check_mesh(obj)
    meshes.check_local(obj)
    pose = find(obj, name)
    motions, _ = motions_of(obj, name)
    handles = obj.arap.controls
    indices = placing.working_handles(obj, bpy.context.evaluated_depsgraph_get())
    names = [handles[i].name for i in indices]
    partners = blend.partners(
        names,
        [bpy.utils.flip_name(handle_name) for handle_name in names],
        np.array([handles[i].rest.translation for i in indices], dtype=np.float64).reshape(-1, 3),
        axis,
        PARTNER_REACH * diagonal_of(meshes.read_rest(obj)),
        {row for row, index in enumerate(indices) if index in motions},
    )
    images = {indices[other]: blend.mirrored(motions[indices[row]], axis) for row, other in partners.items()}
    if not images:
        raise ValueError(f"All handles of pose '{name}' are gone: there is nothing to mirror")
    flipped = bpy.utils.flip_name(pose.name)
    return _write(obj, obj.arap.poses.add(), flipped if flipped != name else f"{name} mirrored", images)


def motions_of(obj: bpy.types.Object, pose: PoseRef) -> tuple[Motions, list[str]]:
    """The motions of a pose, and the names of stored handles that are gone or do not work."""
    if pose is NOW:
        return _motions_now(obj), []
    working = set(placing.working_handles(obj, bpy.context.evaluated_depsgraph_get()))
    if isinstance(pose, Standing):
        return {i: np.eye(4) for i in working}, []
    stored = find(obj, pose).motions
    handles = obj.arap.controls
    index_of = {handle.pose_id: i for i, handle in enumerate(handles) if handle.pose_id}
    matched = [index_of.get(item.handle_id, -1) for item in stored]
    motions: Motions = {}
    gone = []
    for item, match in zip(stored, matched, strict=True):
        by_name = handles.find(item.name)
        index = by_name if match < 0 and by_name not in matched else match
        if index in working:
            motions[index] = np.array(item.motion, dtype=np.float64).reshape(4, 4)
        else:
            gone.append(item.name)
    return motions, gone


def make_name_unique(obj: bpy.types.Object, pose: ArapStoredPose) -> None:
    """Adds a number to the name of a pose if another pose has it; an empty name becomes Pose."""
    others = {other.name for other in obj.arap.poses if other != pose}
    unique = naming.unique(pose.name or "Pose", others)
    if pose.name != unique:
        pose.name = unique


def _write(obj: bpy.types.Object, pose: ArapStoredPose, name: str, motions: Motions) -> ArapStoredPose:
    pose.motions.clear()
    for index, motion in motions.items():
        handle = obj.arap.controls[index]
        item = pose.motions.add()
        item.name = handle.name
        item.handle_id = handle.number
        item.motion = motion.ravel().tolist()
    if pose.name != name:
        pose.name = naming.cut(name)
    obj.arap.active_pose_index = obj.arap.poses.find(pose.name)
    return pose


def _motions_now(obj: bpy.types.Object) -> Motions:
    depsgraph = bpy.context.evaluated_depsgraph_get()
    world, working = handle_motion.object_matrix(obj, depsgraph), placing.working_handles(obj, depsgraph)
    return {i: handle_motion.motion_of(obj.arap.controls[i], depsgraph, world) for i in working}


def _between(
    obj: bpy.types.Object,
    first: Motions,
    second: Motions,
    indices: list[int],
    factor: float,
    depsgraph: bpy.types.Depsgraph,
) -> Motions:
    # The ends need no blend, so they may be flat or turned inside out.
    if factor in {0.0, 1.0} or not indices:
        return {i: (second if factor else first)[i] for i in indices}
    handles = [obj.arap.controls[i] for i in indices]
    blended = blend.blended(
        [handle.name for handle in handles],
        np.array([first[i] for i in indices]),
        np.array([second[i] for i in indices]),
        factor,
        np.array([handle.rest.translation for handle in handles], dtype=np.float64),
        meshes.read_stretch(obj, depsgraph),
    )
    return dict(zip(indices, blended, strict=True))


CALLBACKS = ((hooks.pose_renamed, make_name_unique),)
