# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes, writes and removes the linked keys of an attached object. Errors are shown in the list; the host goes on."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..core import native
from ..core.arrays import Float32s
from ..engine.interaction import print_fault
from ..scene import meshes, shape_keys, versions
from ..scene.console import say
from . import linked_keys, problems, states, wraps

if TYPE_CHECKING:
    from ..props.attach import ArapAttachment
    from .states import State

_busy: set[int] = set()
"""Uids of the objects that are written now: those of a damaged file may be attached in a circle."""


def problem_of(host: bpy.types.Object, attachment: ArapAttachment) -> str:
    """Why an object does not follow its host now, or why Blender does not show that; '' if it does."""
    problem = problems.problem_of(host, attachment)
    if problem:
        return problem
    return states.of(attachment.object.session_uid).error or linked_keys.why_hidden(host, attachment.object)


def guarded(host: bpy.types.Object, attachment: ArapAttachment, act: Callable[[], object]) -> None:
    """Calls ``act`` if the object can be written. Does not raise: an attached object must not stop its host."""
    if attachment.object is None or attachment.object.session_uid in _busy:
        return
    name, uid = attachment.object.name, attachment.object.session_uid
    state = states.of(uid)
    _busy.add(uid)
    try:
        problem = problems.problem_of(host, attachment)
        if problem:
            if attachment.object.arap.attached_to.host == host:  # not of a copy
                state.add_pending(linked_keys.names_of(host))
            _report(state, problem)
        else:
            state.error = ""
            act()
    except native.ERRORS as error:
        state.error = native.sentence_of(error)
        _report(state, state.error)
    except Exception as error:  # noqa: BLE001 - as the text says
        state.error = f"'{name}' does not follow '{host.name}' because of a fault in the add-on: {error}"
        print_fault(error)
    finally:
        _busy.discard(uid)


def _report(state: State, text: str) -> None:
    """Prints a problem once, where there is no list to look at."""
    if bpy.app.background and state.reported != text:
        state.reported = text
        say(f"ARAP: {text}")


def sync(host: bpy.types.Object, attachment: ArapAttachment, *, may_wait: bool = False) -> None:
    """Makes and removes linked keys, and writes those that are queued.

    Args:
        may_wait: what must be bound first stays queued.

    Raises:
        As write().
    """
    attached = attachment.object
    state = states.of(attached.session_uid)
    names = linked_keys.names_of(host) if attachment.is_enabled else []
    linked_keys.release_renamed(host, attached)
    linked_keys.keep_only(attached, names)
    queued = state.add_pending(name for name in names if linked_keys.find(attached, name) is None)
    if not may_wait and state.wrap is not None:
        state.must_check = True
        if wraps.get(host, attachment) is None:
            queued = state.add_pending(names)
    state.done(queued.difference(names))
    linked_keys.add_drivers(host, attached)
    is_any_new = False
    for name in [name for name in names if name in queued]:
        positions = versions.read_key(shape_keys.find(host, name))
        is_any_new |= _write(host, attachment, name, positions, may_wait=may_wait)
    if is_any_new:
        shape_keys.notify_keys_changed(attached)


def write(
    host: bpy.types.Object, attachment: ArapAttachment, name: str, positions: Float32s, *, may_wait: bool = False
) -> None:
    """Writes the key that is linked to the host's key of that name. It is made if there is none.

    Args:
        positions: (m, 3) float32 of the host's key.
        may_wait: if the object must be bound first, the key stays queued.

    Raises:
        ValueError: there is no reference key any more, or as wraps.bound().
    """
    if _write(host, attachment, name, positions, may_wait=may_wait):
        shape_keys.notify_keys_changed(attachment.object)


def _write(
    host: bpy.types.Object, attachment: ArapAttachment, name: str, positions: Float32s, *, may_wait: bool
) -> bool:
    """As write(), but notifies nobody of a new key; returns whether there is one."""
    attached = attachment.object
    if attached.data.shape_keys is None:  # made now, it could be missing after an undo
        raise ValueError(f"'{attached.name}' has lost its shape keys: press Attach again")
    key, shape = linked_keys.find(attached, name), _shape(host, attachment, positions, may_wait=may_wait)
    if key is None:
        linked_keys.make(host, attached, name, meshes.read_rest(attached) if shape is None else shape)
    elif shape is not None and (may_wait or not np.array_equal(shape, versions.read_key(key))):
        shape_keys.write(attached, key, shape, is_frame=may_wait)
    state = states.of(attached.session_uid)
    if shape is None:
        state.add_pending([name])
    else:
        state.done([name])
    return key is None


def _shape(
    host: bpy.types.Object, attachment: ArapAttachment, positions: Float32s, *, may_wait: bool
) -> Float32s | None:
    """(n, 3) float32 of the attached object for ``positions`` of its host; None if it must be bound first."""
    wrap = wraps.get(host, attachment, may_check=not may_wait)
    if wrap is None and np.array_equal(positions, meshes.read_rest(host)):
        return meshes.read_rest(attachment.object)
    if wrap is None and may_wait:
        return None
    return wraps.bound(host, attachment).carried(positions)
