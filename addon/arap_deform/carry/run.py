# SPDX-License-Identifier: GPL-3.0-or-later
"""Followers go along however the shape keys of their body come to be: see props/hooks and scene/shape_keys.

Whatever writes a key waits for the followers. Only the frames of a motion do not: a follower that must be bound first,
or that nobody sees, is late then, and a timer catches up.
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
from . import late, problems, twins, wraps
from .keep_up import guarded, keep_up, write

if TYPE_CHECKING:
    from ..props.carry import ArapFollower

TIMER_S = 0.05
REST_S = 0.3  # followers that nobody sees are written when the bodies have not moved for this time
EDITING = {"EDIT", "SCULPT"}

_moved_at = 0.0  # when a body moved last


def look_again(body: bpy.types.Object, follower: ArapFollower, *, may_wait: bool) -> None:
    """Brings a new follower up to date, or one that has changed. ``may_wait``: it is bound in the background."""
    if follower.target is None or follower.target.arap.carried.body != body:
        return
    known.add(body)
    known.add(follower.target)
    _suspect(body, follower)
    guarded(body, follower, partial(keep_up, body, follower, may_wait=may_wait))
    _wake()


def forget(uid: int) -> None:
    """The object follows nothing any more, or is gone."""
    wraps.forget(uid)
    late.forget(uid)


def _on_key_written(body: bpy.types.Object, key: bpy.types.ShapeKey, positions: Float32s, is_frame: bool) -> None:
    global _moved_at  # noqa: PLW0603 - the timer takes no arguments
    if not body.arap.followers:
        return
    _moved_at = time.monotonic()
    may_wait = is_frame and not bpy.app.background  # without a window no timer catches up
    with wraps.reading_once():
        for follower in body.arap.followers:
            target = follower.target
            if not follower.is_enabled or target is None:
                continue
            if may_wait and target.arap.carried.body == body and not target.visible_get():
                late.add(target.session_uid, [key.name])
                continue
            guarded(body, follower, partial(write, body, follower, key.name, positions, may_wait=may_wait))
    _wake()


def _on_keys_changed(body: bpy.types.Object) -> None:
    with wraps.reading_once():
        for follower in body.arap.followers:
            guarded(body, follower, partial(keep_up, body, follower))


def _on_rest_changes(body: bpy.types.Object, pose: bpy.types.ShapeKey) -> None:
    for target in problems.below(body):
        problems.check(target)  # it would stay behind for good
    if body.arap.carried.body is not None:  # it goes along itself, and is bound at rest
        wraps.suspect(body.session_uid)
        late.add(body.session_uid, [twin.name for twin in body.arap.carried.twins])
    for follower in body.arap.followers:
        if follower.is_enabled:
            guarded(body, follower, partial(_shift_rest, body, follower, pose))


def _shift_rest(body: bpy.types.Object, follower: ArapFollower, pose: bpy.types.ShapeKey) -> None:
    """What the follower shows of the pose will be its rest shape, too."""
    keep_up(body, follower)
    target = follower.target
    twin = twins.find(target, pose.name)
    if twin is None:
        return
    rest = meshes.read_rest(target)
    shown = np.asarray(rest + pose.value * (versions.read_key(twin) - rest), dtype=np.float32)
    shape_keys.shift_all(target, twin, versions.read_key(twin) if pose.value == 1.0 else shown)
    wraps.forget(target.session_uid)
    late.add(target.session_uid, twins.names_of(body))


def _on_follower_changed(body: bpy.types.Object, follower: ArapFollower) -> None:
    if follower.target is not None and not follower.is_enabled:
        wraps.stop_binding(follower.target.session_uid)
    look_again(body, follower, may_wait=not bpy.app.background)


def updated(update: known.Update) -> None:
    """After an evaluation."""
    if update.is_deformed:
        _look_at(update.obj, is_moved=update.is_moved)
    if update.is_moved and update.obj.arap.followers:
        _look_at_scale(update.obj, np.array(update.evaluated.matrix_world, dtype=np.float64))


def catch_up_after(depsgraph: bpy.types.Depsgraph) -> None:
    """After an evaluation, when all updates are noted."""
    if depsgraph.id_type_updated("ACTION"):
        _look_at_keyframes(depsgraph)
    if not late.waiting():
        return
    if not bpy.app.background:
        _wake()
    elif not is_rendering():
        _catch_up_now()


def _look_at(obj: bpy.types.Object, *, is_moved: bool) -> None:
    """Notes what the artist has done to the meshes and keys of a body or follower.

    ``is_moved``: its matrix has changed, too. Object > Apply may have done that, and must be seen before more changes.
    """
    settings = obj.arap
    body = settings.carried.body
    pairs = [(obj, follower) for follower in settings.followers]
    if body is not None:
        pairs += [(body, follower) for follower in body.arap.followers if follower.target == obj]
    pairs = [(body, follower) for body, follower in pairs if follower.target is not None]
    if not pairs:
        return
    if obj.mode in EDITING:
        late.edited.add(obj.session_uid)
        return
    was_edited = obj.session_uid in late.edited
    late.edited.discard(obj.session_uid)
    for body, follower in pairs:
        uid = follower.target.session_uid
        is_other = is_moved and wraps.is_bound(uid) and not problems.problem_of(body, follower)
        is_other = is_other and wraps.get(body, follower, may_look=False) is None
        if was_edited or is_other:
            _suspect(body, follower)
        elif not twins.are_all_there(body, follower.target):
            late.add(uid)


def _look_at_keyframes(depsgraph: bpy.types.Depsgraph) -> None:
    """The keyframes of bodies may have changed: those of twins change, too."""
    actions = [update.id.original for update in depsgraph.updates if isinstance(update.id, bpy.types.Action)]
    animated = (keys for keys in bpy.data.shape_keys if keys.animation_data is not None)
    meshes_of = {keys.user for keys in animated if keys.animation_data.action in actions}
    for body in known.all_objects() if meshes_of else ():
        if body.data in meshes_of:
            for follower in body.arap.followers:
                guarded(body, follower, partial(twins.tie, body, follower.target))


def _look_at_scale(body: bpy.types.Object, world: Floats) -> None:
    """Followers turn as seen. So under another scale, if it is uneven, they are bound again."""
    try:
        stretch = meshes.stretch_in(body, world)
    except ValueError:  # scaled to nothing, for a moment perhaps
        return
    for follower in body.arap.followers:
        if follower.target is not None and not wraps.has_stretch(follower.target.session_uid, stretch):
            _suspect(body, follower)


def _suspect(body: bpy.types.Object, follower: ArapFollower) -> None:
    """It may not be bound to what is there now."""
    uid = follower.target.session_uid
    wraps.suspect(uid)
    late.faults.pop(uid, None)
    late.add(uid, twins.names_of(body))


def _wake() -> None:
    if late.waiting() and not bpy.app.background and not bpy.app.timers.is_registered(_catch_up):
        bpy.app.timers.register(_catch_up, first_interval=0.0, persistent=True)


def _catch_up() -> float | None:
    """The timer."""
    if is_rendering():
        return REST_S
    is_waiting = False

    def step(body: bpy.types.Object, follower: ArapFollower) -> None:
        nonlocal is_waiting
        if _must_wait(body, follower):
            is_waiting = True
        else:
            keep_up(body, follower)
            redraw.tag_meshes()

    _for_late(step)
    if not is_waiting:
        redraw.tag_panels()
    return TIMER_S if is_waiting else None


def _must_wait(body: bpy.types.Object, follower: ArapFollower) -> bool:
    """Whether a follower is not seen while its body moves, or is being bound."""
    target = follower.target
    if time.monotonic() - _moved_at < REST_S and not target.visible_get():
        return True
    if wraps.is_binding(target.session_uid):
        return True
    if wraps.get(body, follower) is not None:
        return False
    if wraps.is_any_binding():  # one after the other: each has all threads, and reading a mesh takes a moment
        return True
    if not any(_is_posed(body, name) for name in late.keys.get(target.session_uid, ())):
        return False
    wraps.begin(body, follower)
    return True


def _is_posed(body: bpy.types.Object, name: str) -> bool:
    """Whether the key is not at rest: else the follower need not be bound for it."""
    key = shape_keys.find(body, name)
    return key is not None and not np.array_equal(versions.read_key(key), meshes.read_rest(body))


def _catch_up_now() -> None:
    _for_late(keep_up)


def _for_late(act: Callable[[bpy.types.Object, ArapFollower], None]) -> None:
    """Calls ``act`` for each late follower that can work."""

    def catch_up(uid: int) -> None:
        found = problems.pair_of(uid)
        if found is None:
            forget(uid)
        elif not problems.problem_of(*found):
            guarded(*found, partial(act, *found))

    with wraps.reading_once():
        for_each(late.waiting(), catch_up)


def undone() -> None:
    """After an undo, to a step in which a follower may have been late, and its arrays others than it is bound from."""
    late.faults.clear()
    wraps.suspect_all()

    def note(uid: int) -> None:
        found = problems.pair_of(uid)
        if found is not None:
            late.add(uid, [pose_key.name_of(found[0])])

    for_each(wraps.uids(), note)
    if bpy.app.background:
        _catch_up_now()
    else:
        _wake()


def clear() -> None:
    """Another file was loaded."""
    wraps.clear()
    late.clear()


@persistent
def _before_saving(*_: object) -> None:
    _catch_up_now()


CALLBACKS = (
    (hooks.key_written, _on_key_written),
    (hooks.keys_changed, _on_keys_changed),
    (hooks.rest_changes, _on_rest_changes),
    (hooks.follower_changed, _on_follower_changed),
    (bpy.app.handlers.save_pre, _before_saving),
)


def unregister() -> None:
    if bpy.app.timers.is_registered(_catch_up):
        bpy.app.timers.unregister(_catch_up)
    clear()
