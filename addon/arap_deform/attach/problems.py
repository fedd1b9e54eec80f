# SPDX-License-Identifier: GPL-3.0-or-later
"""Why an object cannot be attached to a mesh, or does not follow it, in words."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import bpy

from ..scene import known, meshes, shape_keys
from ..scene.points import objects as points

if TYPE_CHECKING:
    from ..props.attach import ArapAttachment

BodyOf = Callable[[bpy.types.Object], "bpy.types.Object | None"]

# What the artist can do instead, by the type of the object.
OTHER_TYPES = {
    **dict.fromkeys(("FONT", "META"), "convert it to a mesh first (Object > Convert)"),
    "CURVES": "hair curves follow the surface that they grow on by themselves (Deform Curves on Surface)",
}


def entry_of(host: bpy.types.Object, attached: bpy.types.Object) -> ArapAttachment | None:
    """The attachment of an object to the host, None if there is none."""
    return next((attachment for attachment in host.arap.attachments if attachment.object == attached), None)


def pair_of(uid: int) -> tuple[bpy.types.Object, ArapAttachment] | None:
    """The host and the attachment of an object, None if it is gone."""
    attached = known.find(uid)
    return pair_with(attached) if attached is not None else None


def pair_with(attached: bpy.types.Object) -> tuple[bpy.types.Object, ArapAttachment] | None:
    """The host and the attachment of an object; None for a copy of an attached one."""
    host = attached.arap.attached_to.host
    attachment = entry_of(host, attached) if host is not None else None
    return (host, attachment) if attachment is not None else None


def owner_of(attached: bpy.types.Object) -> bpy.types.Object | None:
    """The mesh of pair_with()."""
    pair = pair_with(attached)
    return pair[0] if pair is not None else None


def is_in_scene(obj: bpy.types.Object) -> bool:
    """Whether an object is in some scene. What is deleted may live on, as long as something points at it."""
    # To look at the scenes takes long in a large file, and what is visible is in one.
    return obj.visible_get() or bool(obj.users_scene)


def left_out_text(obj: bpy.types.Object) -> str:
    """What to do with an object that follows no more, '' for others.

    A copy of an attached object, a part that was separated from one, or one whose host is deleted.
    """
    host = obj.arap.attached_to.host
    if host is None:
        return ""
    if owner_of(obj) is None:
        return f"This is a copy of something that follows '{host.name}': select it, Shift-click that, and press Attach"
    if is_in_scene(host):
        return ""
    instead = "press Remove Stand-in" if host.arap.is_stand_in else "attach it to another mesh"
    return f"It followed '{host.name}', which was deleted: bring that back (Ctrl Z), or {instead}"


def check_new(host: bpy.types.Object, attached: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
    """Raises ValueError if an object cannot be attached to a mesh, and says what to do."""
    whose = f"'{attached.name}' cannot be attached to '{host.name}'"
    if attached == host:
        raise ValueError(f"{whose}: it is the mesh itself")
    if not points.has_points(attached):
        other = OTHER_TYPES.get(attached.type, "it is neither a mesh nor a curve")
        raise ValueError(f"{whose}: {other}")
    if not meshes.is_evaluated(attached, depsgraph):
        raise ValueError(
            f"{whose}: it is disabled in viewports or not in this view layer, so its place is not known; enable it, "
            "or hide it with the eye"
        )
    if _is_handle(host, attached):
        raise ValueError(f"{whose}: it is one of its handles")
    owner = owner_of(attached)
    if owner not in {None, host} and is_in_scene(owner):
        raise ValueError(f"{whose}: it is attached to '{owner.name}' already; detach it there first")
    if attached in above(host):
        raise ValueError(f"{whose}, which is attached to it: that would be a circle")
    check(attached)


def check(attached: bpy.types.Object) -> None:
    """Raises ValueError if the shape keys of a mesh or curve cannot be written now."""
    if attached.data.is_editmode or attached.mode in {"EDIT", "SCULPT"}:
        mode = "Sculpt Mode" if attached.mode == "SCULPT" else "Edit Mode"
        raise ValueError(f"'{attached.name}' is in {mode}: it follows again in Object Mode")
    points.check(attached)
    shape_keys.check_writable(attached)


def problem_of(host: bpy.types.Object, attachment: ArapAttachment) -> str:
    """Why an entry of the list cannot work now, one sentence; '' if it can. Quick, as it is asked at each redraw."""
    attached = attachment.object
    if attached is None or not is_in_scene(attached):
        whose = f"'{attached.name}'" if attached is not None else "The object"
        return f"{whose} is in no scene: bring it back, or remove it from the list"
    if not points.has_points(attached) or attached == host or _is_handle(host, attached):
        return f"'{attached.name}' cannot be attached: remove it from the list"
    owner = attached.arap.attached_to.host
    if owner != host:
        to_what = f"'{owner.name}'" if owner is not None else "nothing"
        return f"'{attached.name}' is attached to {to_what}: press Attach, or remove it from this list"
    if attached in above(host):
        return f"'{attached.name}' and '{host.name}' are attached to each other: detach one of them"
    try:
        meshes.check_local(host)
        check(attached)
    except ValueError as error:
        return str(error)
    return ""


def _is_handle(host: bpy.types.Object, attached: bpy.types.Object) -> bool:
    """An attached handle would be moved by what it moves."""
    return any(handle.target == attached for handle in host.arap.handles)


def below(host: bpy.types.Object) -> list[bpy.types.Object]:
    """The meshes and curves in some scene that are attached to the host, those attached to these, and so on."""
    found = [host]
    for obj in found:  # which grows
        for attachment in obj.arap.attachments:
            attached = attachment.object
            is_there = (
                attachment.is_enabled and attached is not None and points.has_points(attached) and is_in_scene(attached)
            )
            if is_there and attached.arap.attached_to.host == obj and attached not in found:
                found.append(attached)
    return found[1:]


def above(obj: bpy.types.Object, host_of: BodyOf = lambda obj: obj.arap.attached_to.host) -> list[bpy.types.Object]:
    """The host of the object, the host of that, and so on. A circle ends.

    Args:
        host_of: finds the host of an object, None if it has none.
    """
    passed = [obj]
    while (host := host_of(passed[-1])) is not None and host not in passed:
        passed.append(host)
    return passed[1:]
