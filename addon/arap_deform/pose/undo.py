# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a finished interaction one step of undo.

Every G, R or S within an interaction pushes a step of undo, so undo works as usual within it. After it, undo and redo
pass over these steps: in each of them the object has its number (``obj.arap.interaction_number``), and an undo or redo
that lands there goes on in the same direction.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable

import bpy

from ..scene import known

_ended: dict[int, int] = {}
"""The uid of the object, by the number of the interaction."""

_step: Callable[[], set[str]] | None = None  # undo or redo, whichever came last


def mark(obj: bpy.types.Object) -> int:
    """Gives the object the number of a new interaction and returns it. Every later step of undo has that number."""
    number = 1 + secrets.randbelow(2**31 - 2)
    obj.arap.interaction_number = number
    return number


def is_within(obj: bpy.types.Object, number: int) -> bool:
    """Whether the present state of the scene belongs to the interaction."""
    return bool(obj.arap.interaction_number == number)


def finish(uid: int, number: int, *, as_one_step: bool) -> None:
    """Takes the number away; the caller pushes the step to keep.

    Args:
        uid: of the posed object.
        number: of the interaction.
        as_one_step: undo and redo pass over the steps within the interaction.
    """
    for obj in bpy.data.objects:  # a copy that was made within the interaction has the number too
        if obj.is_property_set("arap") and obj.arap.interaction_number == number:
            obj.arap.interaction_number = 0
    if as_one_step:
        _ended[number] = uid


def _objects_within_ended() -> list[bpy.types.Object]:
    found = ((number, known.find(uid)) for number, uid in _ended.items())
    return [obj for number, obj in found if obj is not None and is_within(obj, number)]


def pass_over(step: Callable[[], set[str]]) -> None:
    """After ``step``, an undo or redo: has a timer go on with it, because the present one has not ended yet."""
    global _step  # noqa: PLW0603 - a timer takes no arguments
    _step = step
    if _objects_within_ended() and not bpy.app.timers.is_registered(_go_on):
        # Persistent: Blender never lets go of the function of a timer that a loaded file has dropped.
        bpy.app.timers.register(_go_on, first_interval=0.0, persistent=True)


def _go_on() -> float | None:
    """The timer: goes one step in the direction of the last undo or redo, until the interaction is passed."""
    if not _objects_within_ended() or _step is None:
        return None  # another undo or redo has passed the interaction
    within, windows = _objects_within_ended(), bpy.context.window_manager.windows
    window = next((w for w in windows if any(known.is_in(w.scene, obj) for obj in within)), windows[0])
    with bpy.context.temp_override(window=window):
        is_last = not _step.poll() or "FINISHED" not in _step()  # type: ignore[attr-defined]
    if is_last:  # Blender has forgotten older steps
        for obj in _objects_within_ended():
            obj.arap.interaction_number = 0
    return 0.0 if _objects_within_ended() else None


def forget() -> None:
    """Another file has other steps."""
    _ended.clear()


def unregister() -> None:
    if bpy.app.timers.is_registered(_go_on):
        bpy.app.timers.unregister(_go_on)
    forget()
