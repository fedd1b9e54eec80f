# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a finished posing act one step of undo.

Every G, R or S within an act pushes a step of its own, so that undo works inside it as anywhere. Once the act has
ended, those steps are passed over: the object carries the act's number in each of them (``obj.arap.pose_act``), and
an undo or redo that lands on one goes on in the same direction.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable

import bpy
from bpy.app.handlers import persistent

from ..core import worker
from ..scene import app_handlers

_ended: dict[int, str] = {}
"""Numbers of the acts to pass over, and the names of their objects."""

WAIT_S = 0.05

_step: Callable[[], set[str]] | None = None  # undo or redo, whichever came last


def mark(obj: bpy.types.Object) -> int:
    """Gives the object the number of a new act, which every step of undo has from here on; returns the number."""
    number = 1 + secrets.randbelow(2**31 - 2)
    obj.arap.pose_act = number
    return number


def unmark(obj: bpy.types.Object) -> None:
    """The act never began."""
    obj.arap.pose_act = 0


def push(message: str) -> None:
    """Pushes a step."""
    bpy.ops.ed.undo_push(message=message)


def is_within(obj: bpy.types.Object, number: int) -> bool:
    """True where the state of the scene belongs to the act."""
    return bool(obj.arap.pose_act == number)


def finish(name: str, number: int, *, as_one_step: bool) -> None:
    """Ends the marking; the caller pushes the step to keep.

    Args:
        name: of the object that was posed.
        number: of the act.
        as_one_step: pass over the steps within the act from now on.
    """
    for obj in bpy.data.objects:  # a copy made within the act has the number too
        if obj.arap.pose_act == number:
            obj.arap.pose_act = 0
    if as_one_step:
        _ended[number] = name


def _objects_within_ended() -> list[bpy.types.Object]:
    objects = bpy.data.objects
    return [objects[name] for number, name in _ended.items() if name in objects and is_within(objects[name], number)]


def _pass_over(step: Callable[[], set[str]]) -> None:
    """Goes on with undo or redo, from a timer: not within the one that is just ending."""
    global _step  # noqa: PLW0603 - a timer takes no arguments
    _step = step
    if _objects_within_ended() and not bpy.app.timers.is_registered(_go_on):
        bpy.app.timers.register(_go_on, first_interval=0.0, persistent=True)  # see handlers


def _go_on() -> float | None:
    """A timer: one step in the direction of the last undo or redo, until the act is behind."""
    if worker.is_any_running():  # an operator under an override must wait, see Binding
        return WAIT_S
    if not _objects_within_ended() or _step is None:
        return None  # somebody has gone on meanwhile
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        is_last = not _step.poll() or "FINISHED" not in _step()  # type: ignore[attr-defined]
    if is_last:  # older steps have been forgotten: this is the oldest state there is
        for obj in _objects_within_ended():
            obj.arap.pose_act = 0
    return 0.0 if _objects_within_ended() else None


@persistent
def _after_undo(*_: object) -> None:
    _pass_over(bpy.ops.ed.undo)


@persistent
def _after_redo(*_: object) -> None:
    _pass_over(bpy.ops.ed.redo)


@persistent
def _after_load(*_: object) -> None:
    _ended.clear()  # another file, another history


_HANDLERS = (("undo_post", _after_undo), ("redo_post", _after_redo), ("load_post", _after_load))


def register() -> None:
    app_handlers.add(_HANDLERS)


def unregister() -> None:
    app_handlers.remove(_HANDLERS)
    if bpy.app.timers.is_registered(_go_on):
        bpy.app.timers.unregister(_go_on)
    _ended.clear()
