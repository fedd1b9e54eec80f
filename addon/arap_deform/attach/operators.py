# SPDX-License-Identifier: GPL-3.0-or-later
"""Attach, Detach, Select Host."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

from ..core.naming import counted, listed
from ..ui.checks import (
    ArapOperator,
    arap_object,
    check_visible,
    select_alone,
    why_busy_but_posed,
    why_not_changeable,
    why_not_object_mode,
)
from .attachments import attach, detach, detach_at
from .hosts import host_of, moving_mesh
from .near import find_near
from .problems import owner_of

NOTHING_ATTACHED = "Nothing is attached to this mesh"
KINDS = {"MESH", "CURVE", "CURVES", "SURFACE", "FONT", "META"}  # what an artist may select to attach


def selected_besides(context: bpy.types.Context, host: bpy.types.Object) -> list[bpy.types.Object]:
    """What is selected besides the host and its handles, with a shape."""
    moving = {handle.target for handle in host.arap.handles}
    return [
        other for other in context.selected_objects if other.type in KINDS and other != host and other not in moving
    ]


def why_no_host(context: bpy.types.Context) -> str:
    """As why_not_changeable(). The mesh must be in Object Mode."""
    return why_not_changeable(context) or why_not_object_mode(arap_object(context))


def why_nothing_attached(context: bpy.types.Context) -> str:
    """As why_no_host(), also of the mesh's own host. Something must be attached to the mesh, or the mesh to that."""
    reason = why_no_host(context)
    if reason or arap_object(context).arap.attachments:
        return reason
    owner = owner_of(arap_object(context))
    return why_busy_but_posed(owner) if owner is not None else NOTHING_ATTACHED


def why_no_host_of_it(context: bpy.types.Context) -> str:
    """As why_no_host(). The mesh must be attached to another one."""
    return why_no_host(context) or ("" if host_of(arap_object(context)) else "This mesh is attached to nothing")


def attached_text(host: bpy.types.Object, objects: Sequence[bpy.types.Object]) -> str:
    names = listed([obj.name for obj in objects])
    return f"Attached to '{host.name}': {counted(len(objects), 'object')} ({names})"


class ARAP_OT_attach(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.attach"
    bl_label = "Attach"
    bl_description = (
        "The other selected objects follow the active mesh however it is posed: clothes, hair, eyes. If it is selected "
        "alone: its children, and what lies on it or in it. Press again after you have moved them"
    )
    why_not = staticmethod(why_no_host)

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        objects = selected_besides(context, obj) or find_near(obj, context.view_layer)
        if not objects:
            raise ValueError(f"No other mesh is near '{obj.name}': select what should follow, then it, and Attach")
        attach(obj, objects, may_wait=True)
        self.report({"INFO"}, attached_text(obj, objects))


class ARAP_OT_detach(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.detach"
    bl_label = "Detach"
    bl_description = (
        "The chosen object of the list follows no more, or this mesh if it has no list. It loses the shape keys that "
        "were made for that"
    )
    why_not = staticmethod(why_nothing_attached)
    ends_itself = True

    def modify(self, _context: bpy.types.Context, obj: bpy.types.Object) -> None:
        owner = owner_of(obj)
        if obj.arap.attachments:
            detach_at(obj, obj.arap.active_attachment_index)
        elif owner is not None:
            detach(owner, obj)
        else:
            raise ValueError(NOTHING_ATTACHED)


class ARAP_OT_host_select(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.host_select"
    bl_label = "Select Host"
    bl_description = "Select the mesh that this one follows, to pose that"
    why_not = staticmethod(why_no_host_of_it)
    ends_itself = True

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        host = moving_mesh(obj)
        check_visible(host)
        select_alone(context, host)
