# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps attached objects in sync with the shape keys of their host, whatever writes them: see props/hooks.

Whoever writes a key waits for the attached objects, but for frames of a motion: then an object that must be bound
first, or that is hidden, is queued, and a timer writes it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ..core.arrays import Float32s, Floats
from ..engine.scene import is_rendering
from ..props import hooks
from ..scene import known, meshes, pose_key, redraw, shape_keys, versions
from ..scene.registration import for_each
from . import linked_keys, problems, states, wraps
from .sync import guarded, sync, write

if TYPE_CHECKING:
    from ..props.attach import ArapAttachment

TIMER_S = 0.05
REST_S = 0.3  # hidden objects are written when no host has moved for this time
EDITING = {"EDIT", "SCULPT"}

_moved_at = 0.0  # time of the last motion of a host


def sync_changed(host: bpy.types.Object, attachment: ArapAttachment, *, may_wait: bool) -> None:
    """After a new attachment, or a change of one. ``may_wait``: it is bound in the background."""
    if attachment.object is None or attachment.object.arap.attached_to.host != host:
        return
    known.add(host)
    known.add(attachment.object)
    _queue_check(host, attachment)
    guarded(host, attachment, partial(sync, host, attachment, may_wait=may_wait))
    _start_timer()


def forget(uid: int) -> None:
    """The object is attached no more, or is gone."""
    wraps.unbind(uid)
    states.forget(uid)


def _on_key_written(host: bpy.types.Object, key: bpy.types.ShapeKey, positions: Float32s, is_frame: bool) -> None:
    global _moved_at  # noqa: PLW0603 - the timer takes no arguments
    if not host.arap.attachments:
        return
    _moved_at = time.monotonic()
    may_wait = is_frame and not bpy.app.background  # without a window no timer runs
    with wraps.reading_once():
        for attachment in host.arap.attachments:
            attached = attachment.object
            if not attachment.is_enabled or attached is None:
                continue
            if may_wait and attached.arap.attached_to.host == host and not attached.visible_get():
                states.of(attached.session_uid).add_pending([key.name])
                continue
            guarded(host, attachment, partial(write, host, attachment, key.name, positions, may_wait=may_wait))
    _start_timer()


def _on_keys_changed(host: bpy.types.Object) -> None:
    with wraps.reading_once():
        for attachment in host.arap.attachments:
            guarded(host, attachment, partial(sync, host, attachment))


def _on_rest_changes(host: bpy.types.Object, pose: bpy.types.ShapeKey) -> None:
    for attached in problems.below(host):
        problems.check(attached)  # it would keep its old rest shape for good
    if host.arap.attached_to.host is not None:  # the host is attached itself, and bound at rest
        state = states.of(host.session_uid)
        state.must_check = True
        state.add_pending(linked.name for linked in host.arap.attached_to.linked_keys)
    for attachment in host.arap.attachments:
        if attachment.is_enabled:
            guarded(host, attachment, partial(_shift_rest, host, attachment, pose))


def _shift_rest(host: bpy.types.Object, attachment: ArapAttachment, pose: bpy.types.ShapeKey) -> None:
    """Makes what the attached object shows of the pose its rest shape, too."""
    sync(host, attachment)
    attached = attachment.object
    key = linked_keys.find(attached, pose.name)
    if key is None:
        return
    rest = meshes.read_rest(attached)
    shown = np.asarray(rest + pose.value * (versions.read_key(key) - rest), dtype=np.float32)
    shape_keys.shift_all(attached, key, versions.read_key(key) if pose.value == 1.0 else shown)
    wraps.unbind(attached.session_uid)
    states.of(attached.session_uid).add_pending(linked_keys.names_of(host))


def _on_attachment_changed(host: bpy.types.Object, attachment: ArapAttachment) -> None:
    if attachment.object is not None and not attachment.is_enabled:
        wraps.stop_binding(attachment.object.session_uid)
    sync_changed(host, attachment, may_wait=not bpy.app.background)


def updated(update: known.Update) -> None:
    """After an evaluation."""
    if update.is_deformed:
        _check_edited(update.obj, is_moved=update.is_moved)
    if update.is_moved and update.obj.arap.attachments:
        _check_scale(update.obj, np.array(update.evaluated.matrix_world, dtype=np.float64))


def write_queued_after(depsgraph: bpy.types.Depsgraph) -> None:
    """After an evaluation, when all updates are noted."""
    if depsgraph.id_type_updated("ACTION"):
        _copy_keyframes(depsgraph)
    if not states.queued():
        return
    if not bpy.app.background:
        _start_timer()
    elif not is_rendering():
        _write_queued()


def _check_edited(obj: bpy.types.Object, *, is_moved: bool) -> None:
    """Queues what the artist's edits of the mesh and keys of a host or an attached object ask for.

    ``is_moved``: its matrix has changed, too. Object > Apply may have done that, and must be seen before more changes.
    """
    settings = obj.arap
    host = settings.attached_to.host
    pairs = [(obj, attachment) for attachment in settings.attachments]
    if host is not None:
        pairs += [(host, attachment) for attachment in host.arap.attachments if attachment.object == obj]
    pairs = [(host, attachment) for host, attachment in pairs if attachment.object is not None]
    if not pairs:
        return
    if obj.mode in EDITING:
        states.in_edit_mode.add(obj.session_uid)
        return
    was_edited = obj.session_uid in states.in_edit_mode
    states.in_edit_mode.discard(obj.session_uid)
    for host, attachment in pairs:
        state = states.of(attachment.object.session_uid)
        is_other = is_moved and state.wrap is not None and not problems.problem_of(host, attachment)
        is_other = is_other and wraps.get(host, attachment, may_check=False) is None
        if was_edited or is_other:
            _queue_check(host, attachment)
        elif not linked_keys.are_all_there(host, attachment.object):
            state.add_pending()


def _copy_keyframes(depsgraph: bpy.types.Depsgraph) -> None:
    """Linked keys have the keyframes of their hosts' keys, which may have changed."""
    actions = [update.id.original for update in depsgraph.updates if isinstance(update.id, bpy.types.Action)]
    animated = (keys for keys in bpy.data.shape_keys if keys.animation_data is not None)
    meshes_of = {keys.user for keys in animated if keys.animation_data.action in actions}
    for host in known.all_objects() if meshes_of else ():
        if host.data in meshes_of:
            for attachment in host.arap.attachments:
                guarded(host, attachment, partial(linked_keys.add_drivers, host, attachment.object))


def _check_scale(host: bpy.types.Object, world: Floats) -> None:
    """Attached objects turn as seen. So they are bound again under another uneven scale."""
    try:
        stretch = meshes.stretch_in(host, world)
    except ValueError:  # scaled to nothing, for a moment perhaps
        return
    for attachment in host.arap.attachments:
        wrap = states.of(attachment.object.session_uid).wrap if attachment.object is not None else None
        if wrap is not None and not wrap.has_stretch(stretch):
            _queue_check(host, attachment)


def _queue_check(host: bpy.types.Object, attachment: ArapAttachment) -> None:
    """The bind may not fit any more."""
    state = states.of(attachment.object.session_uid)
    state.must_check, state.error = True, ""
    state.add_pending(linked_keys.names_of(host))


def _start_timer() -> None:
    if states.queued() and not bpy.app.background and not bpy.app.timers.is_registered(_on_timer):
        bpy.app.timers.register(_on_timer, first_interval=0.0, persistent=True)


def _on_timer() -> float | None:
    if is_rendering():
        return REST_S
    is_waiting = False

    def step(host: bpy.types.Object, attachment: ArapAttachment) -> None:
        nonlocal is_waiting
        if _must_wait(host, attachment):
            is_waiting = True
        else:
            sync(host, attachment)
            redraw.tag_meshes()

    _for_queued(step)
    if not is_waiting:
        redraw.tag_panels()
    return TIMER_S if is_waiting else None


def _must_wait(host: bpy.types.Object, attachment: ArapAttachment) -> bool:
    """Whether an object is hidden while its host moves, or is being bound."""
    attached = attachment.object
    if time.monotonic() - _moved_at < REST_S and not attached.visible_get():
        return True
    if wraps.is_binding(attached.session_uid):
        return True
    if wraps.get(host, attachment) is not None:
        return False
    if states.is_any_binding():  # one after the other: each has all threads, and reading a mesh takes a moment
        return True
    if not any(_is_posed(host, name) for name in states.of(attached.session_uid).pending or ()):
        return False
    wraps.begin(host, attachment)
    return True


def _is_posed(host: bpy.types.Object, name: str) -> bool:
    """Whether the key is not at rest: else the object need not be bound for it."""
    key = shape_keys.find(host, name)
    return key is not None and not np.array_equal(versions.read_key(key), meshes.read_rest(host))


def _write_queued() -> None:
    _for_queued(sync)


def _for_queued(act: Callable[[bpy.types.Object, ArapAttachment], None]) -> None:
    """Calls ``act`` for each queued object that can be written."""

    def act_on(uid: int) -> None:
        found = problems.pair_of(uid)
        if found is None:
            forget(uid)
        elif not problems.problem_of(*found):
            guarded(*found, partial(act, *found))

    with wraps.reading_once():
        for_each(states.queued(), act_on)


def undone() -> None:
    """After an undo: objects may have been queued in that step, and their binds may be of other arrays."""

    def queue(uid: int) -> None:
        state, found = states.of(uid), problems.pair_of(uid)
        state.error = ""
        if state.wrap is None:
            return
        state.must_check = True
        if found is not None:
            state.add_pending([pose_key.name_of(found[0])])

    for_each(states.all_states(), queue)
    if bpy.app.background:
        _write_queued()
    else:
        _start_timer()


def clear() -> None:
    """Another file was loaded."""
    for uid in states.all_states():
        forget(uid)
    states.in_edit_mode.clear()


@persistent
def _before_saving(*_: object) -> None:
    _write_queued()


CALLBACKS = (
    (hooks.key_written, _on_key_written),
    (hooks.keys_changed, _on_keys_changed),
    (hooks.rest_changes, _on_rest_changes),
    (hooks.attachment_changed, _on_attachment_changed),
    (bpy.app.handlers.save_pre, _before_saving),
)


def unregister() -> None:
    if bpy.app.timers.is_registered(_on_timer):
        bpy.app.timers.unregister(_on_timer)
    clear()
