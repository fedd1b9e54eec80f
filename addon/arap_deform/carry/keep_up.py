# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes, writes and removes the twins of one follower. What goes wrong is told in the list; the body goes on."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..core import native
from ..core.arrays import Float32s
from ..engine.act import print_fault
from ..scene import meshes, shape_keys, versions
from ..scene.console import say
from . import late, problems, twins, wraps

if TYPE_CHECKING:
    from ..props.carry import ArapFollower

_busy: set[int] = set()
"""Uids of the followers that are written now: those of a damaged file may go along in a circle."""


def problem_of(body: bpy.types.Object, follower: ArapFollower) -> str:
    """Why an entry of the list does not go along now, or is not seen to, '' if it is."""
    problem = problems.problem_of(body, follower)
    return problem or late.faults.get(follower.target.session_uid, "") or twins.why_hidden(body, follower.target)


def guarded(body: bpy.types.Object, follower: ArapFollower, act: Callable[[], object]) -> None:
    """Calls ``act`` for a follower that can work. Does not raise: nothing of a follower may stop its body."""
    if follower.target is None or follower.target.session_uid in _busy:
        return
    name, uid = follower.target.name, follower.target.session_uid
    _busy.add(uid)
    try:
        fault = problems.problem_of(body, follower)
        if fault:
            if follower.target.arap.carried.body == body:  # not of a copy
                late.add(uid, twins.names_of(body))
            _say(uid, fault)
        else:
            late.faults.pop(uid, None)
            act()
    except native.ERRORS as error:
        late.faults[uid] = native.sentence_of(error)
        _say(uid, late.faults[uid])
    except Exception as error:  # noqa: BLE001 - as the text says
        late.faults[uid] = f"'{name}' does not go along because of a fault in the add-on: {error}"
        print_fault(error)
    finally:
        _busy.discard(uid)


def _say(uid: int, text: str) -> None:
    """Says once what is wrong, where there is no list to look at."""
    if bpy.app.background and late.told.get(uid) != text:
        late.told[uid] = text
        say(f"ARAP: {text}")


def keep_up(body: bpy.types.Object, follower: ArapFollower, *, may_wait: bool = False) -> None:
    """Makes and removes twins, and writes those that are late.

    Args:
        may_wait: what must be bound first stays late.

    Raises:
        As write().
    """
    target = follower.target
    names = twins.names_of(body) if follower.is_enabled else []
    twins.let_go(body, target)
    twins.keep_only(target, names)
    noted = late.add(target.session_uid, [name for name in names if twins.find(target, name) is None])
    if not may_wait and wraps.is_bound(target.session_uid):
        wraps.suspect(target.session_uid)
        if wraps.get(body, follower) is None:
            noted.update(names)
    late.done(target.session_uid, noted.difference(names))
    twins.tie(body, target)
    is_any_new = False
    for name in [name for name in names if name in noted]:
        positions = versions.read_key(shape_keys.find(body, name))
        is_any_new |= _write(body, follower, name, positions, may_wait=may_wait)
    if is_any_new:
        shape_keys.tell_changed(target)
    late.done(target.session_uid, ())


def write(
    body: bpy.types.Object, follower: ArapFollower, name: str, positions: Float32s, *, may_wait: bool = False
) -> None:
    """Writes the twin of the body's key of that name, which is made if there is none.

    Args:
        positions: (m, 3) float32 of the body's key.
        may_wait: if the follower must be bound first, the twin stays late.

    Raises:
        ValueError: there is no reference key any more, or as wraps.bound().
    """
    if _write(body, follower, name, positions, may_wait=may_wait):
        shape_keys.tell_changed(follower.target)


def _write(body: bpy.types.Object, follower: ArapFollower, name: str, positions: Float32s, *, may_wait: bool) -> bool:
    """As write(), but tells nobody of a new twin; returns whether there is one."""
    target = follower.target
    if target.data.shape_keys is None:  # made now, it could be missing after an undo
        raise ValueError(f"'{target.name}' has lost its shape keys: press Carry Along again")
    twin, shape = twins.find(target, name), _shape(body, follower, positions, may_wait=may_wait)
    if twin is None:
        twins.make(body, target, name, meshes.read_rest(target) if shape is None else shape)
    elif shape is not None and (may_wait or not np.array_equal(shape, versions.read_key(twin))):
        shape_keys.write(target, twin, shape, is_frame=may_wait)
    if shape is None:
        late.add(target.session_uid, [name])
    else:
        late.done(target.session_uid, [name])
    return twin is None


def _shape(body: bpy.types.Object, follower: ArapFollower, positions: Float32s, *, may_wait: bool) -> Float32s | None:
    """(n, 3) float32 of the follower for ``positions`` of its body; None if it must be bound first."""
    wrap = wraps.get(body, follower, may_look=not may_wait)
    if wrap is None and np.array_equal(positions, meshes.read_rest(body)):
        return meshes.read_rest(follower.target)
    if wrap is None and may_wait:
        return None
    return wraps.bound(body, follower).carried(positions)
