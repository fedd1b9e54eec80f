# SPDX-License-Identifier: GPL-3.0-or-later
"""Carry Along: what is selected, or near, goes along with the mesh. And Remove."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

from ..core.naming import counted, listed
from ..ui.checks import (
    ArapOperator,
    check_visible,
    posed_object,
    select_alone,
    why_not_changeable,
    why_not_object_mode,
)
from .bodies import body_of, moving_mesh
from .lists import carry_along, remove_at
from .near import find_near

KINDS = {"MESH", "CURVE", "CURVES", "SURFACE", "FONT", "META"}  # what an artist may select to go along


def selected_followers(context: bpy.types.Context, body: bpy.types.Object) -> list[bpy.types.Object]:
    """What is selected besides the body and its handles, with a shape."""
    moving = {handle.target for handle in body.arap.handles}
    return [
        other for other in context.selected_objects if other.type in KINDS and other != body and other not in moving
    ]


def why_no_body(context: bpy.types.Context) -> str:
    """As why_not_changeable(). The mesh must be in Object Mode."""
    return why_not_changeable(context) or why_not_object_mode(posed_object(context))


def why_nothing_selected(context: bpy.types.Context) -> str:
    """As why_no_body(). Something else must be selected, too."""
    reason = why_no_body(context)
    if reason or selected_followers(context, posed_object(context)):
        return reason
    return "Select clothes, hair or eyes, then Shift-click the mesh that they go along with"


def why_no_follower(context: bpy.types.Context) -> str:
    """As why_no_body(). The list must not be empty."""
    return why_no_body(context) or (
        "" if posed_object(context).arap.followers else "Nothing goes along yet: the list is empty"
    )


def why_moved_by_nothing(context: bpy.types.Context) -> str:
    """As why_no_body(). The mesh must go along with another one."""
    return why_no_body(context) or ("" if body_of(posed_object(context)) else "This mesh goes along with nothing")


def added_text(body: bpy.types.Object, objects: Sequence[bpy.types.Object]) -> str:
    names = listed([obj.name for obj in objects])
    return f"Along with '{body.name}': {counted(len(objects), 'object')} ({names})"


class CarryOperator(ArapOperator):
    """A mixin of those that add to the list."""

    def carry(self, body: bpy.types.Object, objects: Sequence[bpy.types.Object]) -> None:
        carry_along(body, objects, may_wait=True)
        self.report({"INFO"}, added_text(body, objects))  # type: ignore[attr-defined]


class ARAP_OT_carry_along(CarryOperator, bpy.types.Operator):
    bl_idname = "arap.carry_along"
    bl_label = "Carry Along"
    bl_description = (
        "The other selected objects go along with the active mesh, however it is posed: clothes, hair, eyes. "
        "Again: their present places count"
    )
    why_not = staticmethod(why_nothing_selected)

    def act(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        self.carry(obj, selected_followers(context, obj))


class ARAP_OT_carry_near(CarryOperator, bpy.types.Operator):
    bl_idname = "arap.carry_near"
    bl_label = "Carry What Is Near"
    bl_description = "Visible meshes and thick curves that are children of this mesh, or lie on it or in it, go along"
    why_not = staticmethod(why_no_body)

    def act(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        found = find_near(obj, context.view_layer)
        if not found:
            raise ValueError(f"No other mesh is near '{obj.name}': select what goes along, then it, and Carry Along")
        self.carry(obj, found)


class ARAP_OT_carry_select(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.carry_select"
    bl_label = "Select What It Goes Along With"
    bl_description = "Select the mesh that moves this one, to pose that"
    why_not = staticmethod(why_moved_by_nothing)
    ends_itself = True

    def act(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        body = moving_mesh(obj)
        check_visible(body)
        select_alone(context, body)


class ARAP_OT_carry_remove(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.carry_remove"
    bl_label = "Remove Follower"
    bl_description = "The chosen object does not go along any more. It loses the shape keys that were made for that"
    why_not = staticmethod(why_no_follower)
    ends_itself = True

    def act(self, _context: bpy.types.Context, obj: bpy.types.Object) -> None:
        remove_at(obj, obj.arap.active_follower_index)
