# SPDX-License-Identifier: GPL-3.0-or-later
"""What every operator and panel asks first: which mesh, and may it be changed."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import bpy

from ..core import native, sessions
from ..core.arrays import Ints
from ..follow.act import PoseAct
from ..follow.scene import is_rendering
from ..scene import meshes, owners, pose_key

STATUS_AGAIN_S = 0.5  # a transform clears the status bar when it ends, so it is set again this often

Execute = Callable[[Any, bpy.types.Context], set[str]]


def posed_object(context: bpy.types.Context) -> bpy.types.Object:
    """As find_posed_object(), where poll() has found one."""
    obj = find_posed_object(context)
    if obj is None:
        raise ValueError("Select a mesh first")
    return obj


def find_posed_object(context: bpy.types.Context) -> bpy.types.Object | None:
    """The mesh that panels and operators mean, None where there is none.

    The active mesh, unless it is a mere handle of one that is being posed; else the mesh that has the active object as
    a handle, so that the panel stays when an empty or an armature is picked; else the one that is being posed; else the
    one selected mesh.
    """
    active = context.object
    found = [_local_object(context.view_layer, name) for name in sessions.acts]
    posed = [obj for obj in found if obj is not None]  # others are of another scene, or renamed
    if active is not None and active.type == "MESH":
        if active.arap.pins or active.arap.handles:
            return active
        return next((obj for obj in posed if owners.is_moved_by(obj, active)), active)
    if active is not None:
        for obj in (*posed, active.parent):
            if obj is not None and owners.is_moved_by(obj, active):
                return obj
        owner = owners.find(context.view_layer, active)
        if owner is not None:
            return owner
    if len(posed) == 1:
        return posed[0]
    chosen = [obj for obj in context.selected_objects if obj.type == "MESH"]
    return chosen[0] if len(chosen) == 1 else None


def find_drawn_object(context: bpy.types.Context) -> bpy.types.Object | None:
    """As find_posed_object(), None too where this 3D view hides it or its overlays."""
    space = context.space_data
    if space is None or not space.overlay.show_overlays:
        return None
    obj = find_posed_object(context)
    return obj if obj is not None and obj.visible_in_viewport_get(space) else None


def _local_object(view_layer: bpy.types.ViewLayer, name: str) -> bpy.types.Object | None:
    """The object of this file with that name, which a linked one may have as well."""
    obj = view_layer.objects.get(name)
    if obj is None or obj.library is None:
        return obj
    return next((other for other in view_layer.objects if other.name_full == name), None)


def why_no_mesh(context: bpy.types.Context) -> str:
    """Why there is nothing to work on; '' where there is."""
    obj = find_posed_object(context)
    if obj is None:
        return "Select a mesh first"
    if obj.library is not None or obj.data.library is not None:
        return "This mesh is linked from another file: make it local first (Object > Relations > Make Local)"
    if meshes.is_override(obj) or meshes.is_override(obj.data):
        return (
            "This mesh is a library override, in which a pose is not saved: make it local first "
            "(Object > Relations > Make Local)"
        )
    return ""


def why_not_idle(context: bpy.types.Context) -> str:
    """As why_no_mesh(), in Object Mode (an armature may be in Pose Mode), and neither an act nor a render has it."""
    reason = why_no_mesh(context)
    if reason:
        return reason
    obj = posed_object(context)
    return why_not_object_mode(obj) or why_busy(obj) or ("Wait until the render has ended" if is_rendering() else "")


def why_not_object_mode(obj: bpy.types.Object) -> str:
    """How Object Mode is reached from the mode that the object is in; '' where it is in it."""
    if obj.mode == "OBJECT":
        return ""
    if obj.mode == "EDIT":
        return "Go to Object Mode first (Tab)"
    return "Go to Object Mode first, in the menu at the top left of the view"


def why_busy(obj: bpy.types.Object) -> str:
    """Which act has the mesh for itself, and how it ends; '' where none has."""
    act = sessions.acts.get(obj.name_full)
    if isinstance(act, PoseAct):
        if act.is_drag:
            return "The mesh is being pulled: wait until it has settled, or press Esc"
        return "End the pose first: Enter keeps it, Esc cancels it"
    # In another window, or by a script.
    return f"Wait for the mesh: {act.doing}" if act is not None else ""


def is_posed(obj: bpy.types.Object) -> bool:
    """Whether a posing act has it; not a drag of its surface."""
    return _posing_act(obj) is not None


def _posing_act(obj: bpy.types.Object) -> PoseAct | None:
    act = sessions.acts.get(obj.name_full)
    return act if isinstance(act, PoseAct) and not act.is_drag else None


def why_busy_but_posed(obj: bpy.types.Object) -> str:
    """As why_busy(), for what may be done within a posing act."""
    act = _posing_act(obj)
    if act is None:
        return why_busy(obj)
    return "Wait: the pose is being kept" if act.is_keeping else ""


def why_not_changeable(context: bpy.types.Context) -> str:
    """As why_no_mesh(), and no act but posing may have it: for pins, handles and what else posing follows."""
    return why_no_mesh(context) or why_busy_but_posed(posed_object(context))


def why_no_pose(context: bpy.types.Context) -> str:
    """As why_not_idle(), and there must be a pose to do something with."""
    reason = why_not_idle(context)
    if reason or pose_key.find(posed_object(context)) is not None:
        return reason
    return "There is no pose yet: press Pose or Solve first"


def why_not_solvable(context: bpy.types.Context) -> str:
    """As why_not_idle(), and there must be a solver and something that moves."""
    return why_not_idle(context) or native.problem() or _why_nothing_moves(posed_object(context))


def why_not_live(context: bpy.types.Context) -> str:
    """Why Live cannot be switched on: there must be a solver, a mesh of this file, and something that moves it."""
    return why_no_mesh(context) or native.problem() or _why_nothing_moves(posed_object(context))


def _why_nothing_moves(obj: bpy.types.Object) -> str:
    if any(handle.is_enabled for handle in obj.arap.handles):
        return ""
    return "Add a handle first: nothing moves the mesh yet"


def why_no_reset(context: bpy.types.Context) -> str:
    """As why_no_pose(), and the mesh must not follow its handles at once again."""
    obj = find_posed_object(context)
    if obj is not None and obj.arap.is_live:
        return "Live would pose the mesh again at once: use Reset Handles, or switch Live off"
    return why_no_pose(context)


def why_not_pullable(context: bpy.types.Context) -> str:
    """As why_not_idle(), and there must be a solver, and the mesh must be seen."""
    reason = why_not_idle(context) or native.problem()
    if reason:
        return reason
    obj = posed_object(context)
    if obj.arap.is_live:
        return "Live would take the mesh back to its handles: switch Live off first, or move the handles"
    space = context.space_data
    if not obj.visible_get(viewport=space if isinstance(space, bpy.types.SpaceView3D) else None):
        return "This mesh is hidden here: show it first (Alt H, its collection, or leave Local View)"
    return ""


def check_visible(obj: bpy.types.Object) -> None:
    """Raises ValueError where the mesh is hidden: then Blender does not let it into other modes."""
    if not obj.visible_get():
        raise ValueError(f"'{obj.name}' is hidden: show it first (Alt H, its collection, or leave Local View)")


def selected_vertices(obj: bpy.types.Object, lack: str) -> Ints:
    """(k,) int32, of a mesh in Edit Mode. Raises ValueError(lack) where there are none."""
    vertices = meshes.selected_vertices(obj)
    if not len(vertices):
        raise ValueError(lack)
    return vertices


def allow(cls: Any, reason: str) -> bool:
    """For poll(): True without a reason; else greyed, with the reason in the tooltip."""
    if reason:
        cls.poll_message_set(reason)
    return not reason


def reports_errors(execute: Execute) -> Execute:
    """Turns errors that api raises for the user into a report and {'CANCELLED'}."""

    @functools.wraps(execute)
    def wrapper(self: Any, context: bpy.types.Context) -> set[str]:
        try:
            return execute(self, context)
        except (ValueError, RuntimeError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}

    return wrapper


class StatusBar:
    """The text in the status bar while an operator runs."""

    def __init__(self) -> None:
        self._workspaces: set[str] = set()
        self._text, self._shown_at = "", 0.0

    def show(self, context: bpy.types.Context, text: str) -> None:
        now = time.monotonic()
        if context.workspace is not None and (text != self._text or now - self._shown_at >= STATUS_AGAIN_S):
            self._text, self._shown_at = text, now
            self._workspaces.add(context.workspace.name)
            context.workspace.status_text_set(text)

    def clear(self) -> None:
        for name in self._workspaces:
            workspace = bpy.data.workspaces.get(name)
            if workspace is not None:
                workspace.status_text_set(None)


@contextmanager
def one_step(obj: bpy.types.Object, name: str) -> Iterator[None]:
    """As object_mode(), and what is done within is one step of undo, also in Edit Mode.

    There Blender's own steps are of the mesh being edited alone: undo would leave pins, handles and stiffness on their
    lists. So an operator that uses this has no option UNDO; in Edit Mode its step is the scene in Object Mode.
    """
    with object_mode(obj):
        yield
        if bpy.ops.ed.undo_push.poll():  # not without a window
            bpy.ops.ed.undo_push(message=name)


@contextmanager
def object_mode(obj: bpy.types.Object) -> Iterator[None]:
    """Leaves Edit Mode for a while: vertex groups cannot be written in it."""
    was_in_edit_mode = obj.mode == "EDIT"
    if was_in_edit_mode:
        bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        if was_in_edit_mode:
            bpy.ops.object.mode_set(mode="EDIT")
