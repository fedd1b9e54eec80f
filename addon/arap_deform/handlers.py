# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender tells the add-on: the scene was evaluated, another frame, an undo, another file.

Each handler tells the rooms in turn. A fault of one, or with one object, keeps no other from its turn.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from operator import call

import bpy
from bpy.app.handlers import persistent

from .attach import sync_handlers as attach
from .core import sessions
from .engine import applied
from .follow import runs
from .pose import run as posing
from .pose import undo
from .pull import draw, evaluated_mesh, region, tool
from .pull import operators as pulling
from .scene import known, registration, ui_cache
from .scene.registration import Hearing, for_each
from .scene.seen import look
from .show import overlay
from .ui import modal


def _tell(*rooms: Callable[[], object]) -> None:
    for_each(rooms, call)


def _forget_looks() -> None:
    """Forgets everything read from the scene."""
    _postponed.clear()
    ui_cache.clear()
    look.clear()
    evaluated_mesh.clear()
    draw.clear()


_postponed: list[known.Update] = []
"""Of evaluations in the middle of a change, which nothing was solved for."""

UPDATED = (
    applied.updated,
    overlay.updated,
    attach.updated,
    ui_cache.forget_updated,
    look.forget_updated,
    evaluated_mesh.forget_updated,
)


def _look_again() -> None:
    """Objects may have come and gone."""
    gone = known.look_again()
    for uid in gone:
        runs.forget(uid)
        attach.forget(uid)
    sessions.forget(gone)


@persistent
def _on_update(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    if registration.hearing is Hearing.NEVER:
        return
    may_be_others = known.may_be_others(depsgraph)
    if may_be_others:
        _look_again()
    if not known.any_objects():
        return
    updates = known.updates(depsgraph)
    for update in updates:
        _tell(*(partial(room, update) for room in UPDATED))
    _tell(
        partial(attach.write_queued_after, depsgraph),
        partial(ui_cache.forget_handles, has_new_objects=may_be_others),
    )
    _postponed.extend(updates)
    if registration.hearing is Hearing.NOW:
        updates = _postponed.copy()
        _postponed.clear()
        _tell(
            partial(runs.scene_changed, scene, depsgraph, updates),
            partial(posing.scene_changed, scene, depsgraph, updates),
        )


@persistent
def _on_frame(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    if known.are_more_or_fewer():  # each frame is another scene for Blender
        _look_again()
    if not known.any_objects():
        return
    for_each(known.updates(depsgraph), applied.updated)
    _tell(
        partial(runs.frame_changed, scene, depsgraph),
        overlay.frame_changed,
        evaluated_mesh.forget_places,
        partial(posing.scene_changed, scene, depsgraph, None),
    )


@persistent
def _on_undo(scene: bpy.types.Scene, *_: object) -> None:
    _undone(scene, bpy.ops.ed.undo)


@persistent
def _on_redo(scene: bpy.types.Scene, *_: object) -> None:
    _undone(scene, bpy.ops.ed.redo)


def _undone(scene: bpy.types.Scene, step: Callable[[], set[str]]) -> None:
    _look_again()
    _tell(
        _forget_looks,
        overlay.forget,
        applied.replaced,
        partial(runs.undone, scene),
        partial(undo.pass_over, step),
        attach.undone,
        tool.replaced,
        pulling.undone,
        posing.undone,
    )


@persistent
def _on_load(*_: object) -> None:
    known.clear()
    known.look_again()
    _tell(
        _forget_looks,
        region.forget_fine,
        overlay.forget,
        undo.forget,
        attach.clear,
        applied.replaced,
        runs.loaded,
        tool.replaced,
    )


CALLBACKS = (
    (bpy.app.handlers.load_post, _on_load),
    (bpy.app.handlers.depsgraph_update_post, _on_update),
    (bpy.app.handlers.frame_change_post, _on_frame),
    (bpy.app.handlers.undo_post, _on_undo),
    (bpy.app.handlers.redo_post, _on_redo),
)


def unregister() -> None:
    modal.abort_all("The add-on was disabled")
    sessions.clear()
    known.clear()
    _forget_looks()
    region.forget_fine()
