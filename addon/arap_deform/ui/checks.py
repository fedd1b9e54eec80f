# SPDX-License-Identifier: GPL-3.0-or-later
"""What every operator and panel asks first: which mesh, and may it change. And what operators share."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import bpy

from ..core import native, sessions
from ..engine.interaction import Interaction
from ..engine.scene import is_rendering
from ..scene import baked, known, meshes, pose_key, ui_cache

Execute = Callable[..., set[str]]


def arap_object(context: bpy.types.Context) -> bpy.types.Object:
    """As find_arap_object(). Raises ValueError if there is none."""
    obj = find_arap_object(context)
    if obj is None:
        raise ValueError("Select a mesh first")
    return obj


def find_arap_object(context: bpy.types.Context) -> bpy.types.Object | None:
    """The mesh that panels and operators work on, None if there is none.

    The first of: the active mesh, unless it is a handle of a mesh that is being posed; the mesh that
    the active object moves, so the panel stays when an empty or an armature is picked, or its host, if it
    is a curve; the only mesh that is being posed; the only selected mesh.
    """
    obj = _find(context)
    if obj is not None:
        ui_cache.set_panel_object(context.view_layer, obj)
    return obj


def _find(context: bpy.types.Context) -> bpy.types.Object | None:
    active = getattr(context, "object", None)  # a timer or a handler may have no window
    posed = [obj for uid in sessions.locks if (obj := known.find_in(context.view_layer, uid)) is not None]
    if active is not None and active.type == "MESH":
        if active.arap.controls:
            return active
        return next((obj for obj in posed if ui_cache.is_moved_by(obj, active)), active)
    if active is not None:
        for obj in (*posed, active.parent):
            if obj is not None and ui_cache.is_moved_by(obj, active):
                return obj
        owner = ui_cache.owner_of(context.view_layer, active) or active.arap.attached_to.host
        if known.is_in(context.view_layer, owner):
            return owner
    if len(posed) == 1:
        return posed[0]
    chosen = [obj for obj in getattr(context, "selected_objects", ()) if obj.type == "MESH"]
    return chosen[0] if len(chosen) == 1 else None


def find_drawn_object(context: bpy.types.Context) -> bpy.types.Object | None:
    """As find_arap_object(). None too if this 3D view hides the mesh or all overlays."""
    space = context.space_data
    if space is None or not space.overlay.show_overlays:
        return None
    obj = find_arap_object(context)
    return obj if obj is not None and obj.visible_in_viewport_get(space) else None


def why_no_mesh(context: bpy.types.Context) -> str:
    """Why there is no mesh to work on, '' if there is one."""
    obj = find_arap_object(context)
    return why_not_local(obj) if obj is not None else "Select a mesh first"


def why_not_local(obj: bpy.types.Object) -> str:
    """Why a pose of the mesh would not be saved, '' if it would be."""
    if obj.library is not None or obj.data.library is not None:
        return "This mesh is linked from another file: make it local first (Object > Relations > Make Local)"
    if meshes.is_override(obj) or meshes.is_override(obj.data):
        return (
            "This mesh is a library override, in which a pose is not saved: make it local first "
            "(Object > Relations > Make Local)"
        )
    return ""


def why_not_idle(context: bpy.types.Context) -> str:
    """As why_no_mesh(). The mesh must be in Object Mode, and no task and no render may be using it."""
    return why_no_mesh(context) or _why_not_idle(arap_object(context))


def _why_not_idle(obj: bpy.types.Object) -> str:
    return why_not_object_mode(obj) or why_busy(obj) or ("Wait until the render ends" if is_rendering() else "")


def why_not_object_mode(obj: bpy.types.Object) -> str:
    """How to go to Object Mode, '' if the object is in it."""
    if obj.mode == "OBJECT":
        return ""
    if obj.mode == "EDIT":
        return "Go to Object Mode first (Tab)"
    return "Go to Object Mode first, in the menu at the top left of the view"


def why_busy(obj: bpy.types.Object) -> str:
    """Which task is using the mesh, and how to end it, '' if none is."""
    interaction = sessions.locks.get(obj.session_uid)
    if isinstance(interaction, Interaction):
        if interaction.is_drag:
            return "The mesh is being pulled: wait until it settles, or press Esc"
        return "End the pose first: Enter keeps it, Esc cancels it"
    # From another window, or from a script.
    return f"Wait for the mesh: {interaction.doing}" if interaction is not None else ""


def is_posed(obj: bpy.types.Object) -> bool:
    """Whether an interaction is using the mesh. A drag of its surface is none."""
    return _interaction_of(obj) is not None


def _interaction_of(obj: bpy.types.Object) -> Interaction | None:
    interaction = sessions.locks.get(obj.session_uid)
    return interaction if isinstance(interaction, Interaction) and not interaction.is_drag else None


def why_busy_but_posed(obj: bpy.types.Object) -> str:
    """As why_busy(), for tasks that are allowed while posing."""
    interaction = _interaction_of(obj)
    if interaction is None:
        return why_busy(obj)
    return "Wait: the pose is being kept" if interaction.is_keeping else ""


def why_not_changeable(context: bpy.types.Context) -> str:
    """As why_no_mesh(). No task but posing may be using the mesh: posing follows pins, handles and stiffness."""
    return why_no_mesh(context) or why_busy_but_posed(arap_object(context))


def why_no_pose(context: bpy.types.Context) -> str:
    """As why_not_idle(). The mesh must show a pose."""
    reason = why_not_idle(context)
    if reason:
        return reason
    lack = "There is no pose yet: pull the mesh or move a handle first"
    return why_baked(arap_object(context)) if pose_key.find(arap_object(context)) is not None else lack


def why_not_solvable(context: bpy.types.Context) -> str:
    """As why_not_idle(). There must be a solver, and a handle."""
    return why_not_idle(context) or native.problem() or _why_nothing_moves(arap_object(context))


def why_not_posable(context: bpy.types.Context) -> str:
    """As why_not_solvable(). No bake may show in place of the pose."""
    return why_not_solvable(context) or why_baked(arap_object(context))


def why_baked(obj: bpy.types.Object) -> str:
    """How to go on posing after a bake, '' if none shows in place of the pose."""
    return "The animation is baked: press Edit Again to pose the mesh" if baked.is_shown(obj) else ""


def why_no_follow(context: bpy.types.Context) -> str:
    """As why_no_mesh(). There must be a solver, and a handle."""
    return why_no_mesh(context) or native.problem() or _why_nothing_moves(arap_object(context))


def _why_nothing_moves(obj: bpy.types.Object) -> str:
    if any(control.is_enabled and control.kind != "pin" for control in obj.arap.controls):
        return ""
    return "Add a handle first: nothing moves the mesh yet"


def why_nothing_posed(context: bpy.types.Context) -> str:
    """As why_not_changeable(). The mesh must have handles or show a pose."""
    reason = why_not_changeable(context)
    return reason if reason or arap_object(context).arap.handles else why_no_pose(context)


def why_not_pullable(context: bpy.types.Context, obj: bpy.types.Object | None = None) -> str:
    """As why_not_idle(). There must be a solver, no bake may show, and the mesh must be visible.

    ``obj``: another mesh than the posed one.
    """
    if obj is None:
        obj = find_arap_object(context)
    if obj is None:
        return why_no_mesh(context)
    reason = why_not_local(obj) or _why_not_idle(obj) or native.problem() or why_baked(obj)
    if reason:
        return reason
    space = context.space_data
    if not obj.visible_get(viewport=space if isinstance(space, bpy.types.SpaceView3D) else None):
        return hidden_text(obj)
    return ""


def hidden_text(obj: bpy.types.Object) -> str:
    """What to do if a mesh is not visible. It has a name: it may be what moves the one in hand."""
    return f"'{obj.name}' is hidden here: show it first (Alt H, its collection, or leave Local View)"


def check_visible(obj: bpy.types.Object) -> None:
    """Raises ValueError if the mesh is hidden: Blender does not let it into other modes."""
    if not obj.visible_get():
        raise ValueError(hidden_text(obj))


def select_alone(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """Makes it active and the only selected object, in Object Mode."""
    for other in context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj


def is_last(context: bpy.types.Context, cls: Any) -> bool:
    """Whether an operator was the last task. Adjust Last Operation asks its poll() before the task is taken back."""
    operators = context.window_manager.operators
    return bool(operators) and operators[-1].bl_idname == cls.__name__


def allow(cls: Any, reason: str) -> bool:
    """For poll(): True without a reason. With one the button is grey, and its tooltip gives the reason."""
    if reason:
        cls.poll_message_set(reason)
    return not reason


def reports_errors(execute: Execute) -> Execute:
    """For execute() and the like: turns one of native.ERRORS into a report to the user and {'CANCELLED'}."""

    @functools.wraps(execute)
    def wrapper(self: Any, context: bpy.types.Context, *others: Any) -> set[str]:
        try:
            return execute(self, context, *others)
        except native.ERRORS as error:
            self.report({"ERROR"}, native.sentence_of(error))
            return {"CANCELLED"}

    return wrapper


class ArapOperator:
    """An operator that works on find_arap_object() at once.

    The button is grey if why_not() gives a reason. modify() does the work and may raise ValueError or RuntimeError.
    """

    bl_options = {"REGISTER", "UNDO"}
    bl_label: str
    why_not: Callable[[bpy.types.Context], str] = staticmethod(why_not_changeable)
    ends_itself = False  # after the task why_not() has a reason, but Adjust Last Operation must still work

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if cls.ends_itself and is_last(context, cls):
            return allow(cls, why_not_changeable(context))
        return allow(cls, cls.why_not(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        self.modify(context, arap_object(context))
        return {"FINISHED"}

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        raise NotImplementedError
