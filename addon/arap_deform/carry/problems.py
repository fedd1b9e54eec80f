# SPDX-License-Identifier: GPL-3.0-or-later
"""Why an object cannot go along with a mesh, in words."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import bpy

from ..scene import known, meshes, shape_keys
from ..scene.points import objects as points

if TYPE_CHECKING:
    from ..props.carry import ArapFollower

BodyOf = Callable[[bpy.types.Object], "bpy.types.Object | None"]

# What the artist can do instead, by the type of the object.
OTHER_TYPES = {
    **dict.fromkeys(("FONT", "META"), "convert it to a mesh first (Object > Convert)"),
    "CURVES": "hair curves follow the surface that they grow on by themselves (Deform Curves on Surface)",
}


def entry_of(body: bpy.types.Object, target: bpy.types.Object) -> ArapFollower | None:
    """The entry of an object in the body's list, None if there is none."""
    return next((follower for follower in body.arap.followers if follower.target == target), None)


def pair_of(uid: int) -> tuple[bpy.types.Object, ArapFollower] | None:
    """The body and the entry of a follower, None if it is gone."""
    target = known.find(uid)
    return pair_with(target) if target is not None else None


def pair_with(target: bpy.types.Object) -> tuple[bpy.types.Object, ArapFollower] | None:
    """The mesh that has an object in its list and goes along with it, and its entry there; None for a copy of one."""
    body = target.arap.carried.body
    follower = entry_of(body, target) if body is not None else None
    return (body, follower) if follower is not None else None


def owner_of(target: bpy.types.Object) -> bpy.types.Object | None:
    """The mesh of pair_with()."""
    pair = pair_with(target)
    return pair[0] if pair is not None else None


def is_in_scene(obj: bpy.types.Object) -> bool:
    """Whether an object is in some scene. What is deleted may live on, as long as something points at it."""
    # To look at the scenes takes long in a large file, and what is visible is in one.
    return obj.visible_get() or bool(obj.users_scene)


def left_out_text(obj: bpy.types.Object) -> str:
    """What one has to say that goes along no more; '' for other objects.

    A copy of a follower, a part that was separated from one, or one whose body is deleted.
    """
    body = obj.arap.carried.body
    if body is None:
        return ""
    if owner_of(obj) is None:
        return f"It came from what goes along with '{body.name}', and does not: select it, then that, and Carry Along"
    if is_in_scene(body):
        return ""
    instead = "press Remove Stand-in" if body.arap.is_stand_in else "let it go along with another mesh"
    return f"It went along with '{body.name}', which was deleted: bring that back (Ctrl Z), or {instead}"


def check_new(body: bpy.types.Object, target: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
    """Raises ValueError if an object cannot be added to the followers of a mesh, and says what to do."""
    whose = f"'{target.name}' cannot go along with '{body.name}'"
    if target == body:
        raise ValueError(f"{whose}: it is the mesh itself")
    if not points.has_points(target):
        other = OTHER_TYPES.get(target.type, "it is neither a mesh nor a curve")
        raise ValueError(f"{whose}: {other}")
    if not meshes.is_evaluated(target, depsgraph):
        raise ValueError(
            f"{whose}: it is disabled in viewports or not in this view layer, so its place is not known; enable it, "
            "or hide it with the eye"
        )
    if _is_handle(body, target):
        raise ValueError(f"{whose}: it is one of its handles")
    owner = owner_of(target)
    if owner not in {None, body} and is_in_scene(owner):
        raise ValueError(f"{whose}: it goes along with '{owner.name}' already; remove it from the list there first")
    if target in above(body):
        raise ValueError(f"{whose}, which goes along with it: that would be a circle")
    check(target)


def check(target: bpy.types.Object) -> None:
    """Raises ValueError if the shape keys of a mesh or curve cannot be written now."""
    if target.data.is_editmode or target.mode in {"EDIT", "SCULPT"}:
        mode = "Sculpt Mode" if target.mode == "SCULPT" else "Edit Mode"
        raise ValueError(f"'{target.name}' is in {mode}: it goes along again in Object Mode")
    points.check(target)
    shape_keys.check_writable(target)


def problem_of(body: bpy.types.Object, follower: ArapFollower) -> str:
    """Why an entry of the list cannot work now, one sentence; '' if it can. Quick, as it is asked at each redraw."""
    target = follower.target
    if target is None or not is_in_scene(target):
        whose = f"'{target.name}'" if target is not None else "The object"
        return f"{whose} is in no scene: bring it back, or remove it from the list"
    if not points.has_points(target) or target == body or _is_handle(body, target):
        return f"'{target.name}' cannot go along: remove it from the list"
    owner = target.arap.carried.body
    if owner != body:
        with_whom = f"with '{owner.name}'" if owner is not None else "with nothing"
        return f"'{target.name}' goes along {with_whom}: press Carry Along, or remove it from this list"
    if target in above(body):
        return f"'{target.name}' and '{body.name}' go along with each other: remove one of them"
    try:
        meshes.check_local(body)
        check(target)
    except ValueError as error:
        return str(error)
    return ""


def _is_handle(body: bpy.types.Object, target: bpy.types.Object) -> bool:
    """A handle that went along would be moved by what it moves."""
    return any(handle.target == target for handle in body.arap.handles)


def below(body: bpy.types.Object) -> list[bpy.types.Object]:
    """The meshes and curves in some scene that go along with the body, those that go along with these, and so on."""
    found = [body]
    for obj in found:  # which grows
        for follower in obj.arap.followers:
            target = follower.target
            is_there = follower.is_enabled and target is not None and points.has_points(target) and is_in_scene(target)
            if is_there and target.arap.carried.body == obj and target not in found:
                found.append(target)
    return found[1:]


def above(obj: bpy.types.Object, body_of: BodyOf = lambda obj: obj.arap.carried.body) -> list[bpy.types.Object]:
    """The mesh that the object goes along with, the one with which that does, and so on. A circle ends.

    Args:
        body_of: says with which mesh an object goes along, None: with none.
    """
    passed = [obj]
    while (body := body_of(passed[-1])) is not None and body not in passed:
        passed.append(body)
    return passed[1:]
