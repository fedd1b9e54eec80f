# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on forgets after a load, an evaluation, a new frame, or an undo."""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from .core import sessions
from .pull import draw, region, seen_mesh
from .scene import remembered
from .scene.seen import look
from .ui import modal


def _is_there(name: str) -> bool:
    return bpy.data.objects.get((name, None)) is not None


def _forget_looks() -> None:
    """Forgets everything read from the scene."""
    remembered.clear()
    look.clear()
    seen_mesh.clear()
    draw.clear()


@persistent
def _on_load(*_: object) -> None:
    # live forgets the sessions: its runs must end first.
    _forget_looks()
    region.forget_fine()


@persistent
def _on_update(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    # Objects that only move or deform, as in a drag, are still there. The look-up takes long in a large scene.
    if depsgraph.id_type_updated("SCENE") or not all(
        update.is_updated_geometry or update.is_updated_transform for update in depsgraph.updates
    ):
        sessions.forget_missing(_is_there)
    remembered.forget_updated(depsgraph, sessions.acts)
    look.forget_updated(depsgraph)
    seen_mesh.forget_updated(depsgraph)


@persistent
def _on_frame(*_: object) -> None:
    seen_mesh.forget_places()


@persistent
def _on_undo(*_: object) -> None:
    sessions.forget_missing(_is_there)
    _forget_looks()


CALLBACKS = (
    (bpy.app.handlers.load_post, _on_load),
    (bpy.app.handlers.depsgraph_update_post, _on_update),
    (bpy.app.handlers.frame_change_post, _on_frame),
    (bpy.app.handlers.undo_post, _on_undo),
    (bpy.app.handlers.redo_post, _on_undo),
)


def unregister() -> None:
    modal.abort_all("The add-on was disabled")
    sessions.clear()
    _forget_looks()
    region.forget_fine()
