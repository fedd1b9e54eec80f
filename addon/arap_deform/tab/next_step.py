# SPDX-License-Identifier: GPL-3.0-or-later
"""The line at the top of the tab: what to do next, in every state."""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from ..attach.hosts import host_of
from ..core import sessions
from ..engine.interaction import Interaction, Phase
from ..follow import runs
from ..pull import tool
from ..scene import ui_cache
from ..scene.seen import look
from ..setup.bone_operators import selected_armatures
from ..ui.checks import find_arap_object, is_posed, why_baked, why_no_mesh, why_not_object_mode


@dataclass(frozen=True)
class Step:
    """What to do. ``fraction``: of a mesh that is being prepared."""

    text: str
    icon: str = "INFO"
    fraction: float | None = None


def next_step(context: bpy.types.Context) -> Step:
    obj = find_arap_object(context)
    if obj is None:
        active = getattr(context, "object", None)  # in other modes a click does not select the mesh
        if active is not None and active.type == "ARMATURE" and active.mode == "OBJECT":
            return Step("Shift-click the mesh. Then Add Bones lets the armature move it.")
        return Step((active and why_not_object_mode(active)) or "Click the mesh to pose in the view.")
    if problem := why_no_mesh(context):
        return Step(problem, "ERROR")
    if is_posed(obj):
        return _while_posing(obj)
    if ui_cache.has_foreign_handles(obj):  # first: it stays when a pull forgets the problem of Follow
        return Step("A handle has no own empty: press Copy Handles or remove it.", "ERROR")
    if obj.arap.follow_error:
        return Step(obj.arap.follow_error, "ERROR")
    if obj.mode == "EDIT":
        return Step(_in_edit_mode(obj))
    if reason := why_not_object_mode(obj):
        return Step(reason)
    if why_baked(obj):
        return Step("Edit Again shows the pose in place of the bake.")
    if reason := look.noted(obj):
        return Step(f"{reason}.", "ERROR")
    host = host_of(obj)
    if host is not None:
        return Step(f"This object follows '{host.name}'. Pull moves '{host.name}'.")
    return _with_handles(context, obj) if obj.arap.handles else Step(_without_handles(context, obj))


def _while_posing(obj: bpy.types.Object) -> Step:
    interaction = sessions.locks[obj.session_uid]
    assert isinstance(interaction, Interaction)
    if interaction.phase is Phase.BINDING:
        return Step("Preparing", fraction=interaction.bind_fraction)
    return Step("Move a handle (G, R, S). Enter keeps the pose, Esc cancels it.", "REC")


def _in_edit_mode(obj: bpy.types.Object) -> str:
    if obj.data.total_vert_sel >= len(obj.data.vertices) > 0:  # as on a new mesh
        return "All is selected. Drag a box around a part to move or to hold."
    return "Select a part. Add Handle moves it, Add Pin holds it."


def _without_handles(context: bpy.types.Context, obj: bpy.types.Object) -> str:
    if selected_armatures(context):
        return "Add Bones: the armature moves the mesh, without weights."
    if any(pin.reach > 0.0 for pin in obj.arap.pull_pins):  # pulled, not only pinned
        return "Pull on. To animate it, press Make Handles (Ctrl H)."
    if tool.is_on():
        return "Drag the mesh to pull it. Click it to pin a spot."
    if obj.arap.pins:
        return "Press Pull and drag the mesh, or add a handle in Edit Mode."
    return "Press Pull and drag the mesh. A click on it pins a spot."


def _with_handles(context: bpy.types.Context, obj: bpy.types.Object) -> Step:
    if not obj.arap.use_follow and obj.arap.pull_pins:
        return Step("Make Handles (Ctrl H) keeps what you pulled. Then tick Follow.")
    if not obj.arap.use_follow:
        return Step("Tick Follow, then move a handle: the mesh follows.")
    run = runs.run_of(obj)
    if run is not None and run.pause:
        return Step(run.pause, "PAUSE")
    if run is not None and run.is_binding:
        return Step("Preparing", fraction=run.bind_fraction)
    if len(obj.arap.handles) == 1 and not obj.arap.pins:
        return Step("Nothing holds the mesh. Add Pin in Edit Mode does.")
    moving = [h for h in obj.arap.handles if h.is_enabled and context.object is not None and h.target == context.object]
    if moving and all(handle.bone for handle in moving) and context.mode == "OBJECT":
        return Step("Ctrl Tab: Pose Mode. There G and R move the bones.")
    if moving:
        return Step("Move, turn or scale the handle: G, R, S.", "REC")
    if obj.select_get():
        return Step("Click a handle in the list. Now G would move the whole object.")
    return Step("Click a handle in the list, then press G.")
