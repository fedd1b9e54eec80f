# SPDX-License-Identifier: GPL-3.0-or-later
"""Changes of a mesh in Edit Mode that Blender can make only in Object Mode, as one step of undo."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from ..scene import known, undo_step
from .checks import ArapOperator

_to_edit = 0
"""The uid of the mesh that goes back to Edit Mode when the operator has ended."""
_window = 0  # address of the window in which it does so


@contextmanager
def object_mode(obj: bpy.types.Object) -> Iterator[None]:
    """Leaves Edit Mode for a while: Blender cannot write vertex groups in it."""
    was_in_edit_mode = obj.mode == "EDIT"
    if was_in_edit_mode:
        bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        if was_in_edit_mode:
            bpy.ops.object.mode_set(mode="EDIT")


class OneStepOperator(ArapOperator):
    """An ArapOperator that changes lists in Edit Mode, too: see one_step()."""

    options: bpy.types.OperatorOptions

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        return self.execute(context)

    @contextmanager
    def one_step(self, obj: bpy.types.Object, *, goes_back: bool = True) -> Iterator[None]:
        """As object_mode(). All changes inside are one step of undo. ``goes_back``: to Edit Mode, also for the user.

        When the operator ends, Blender makes the step. In Edit Mode it would hold only the mesh: undo would leave pins,
        handles and stiffness in their lists. So the operator ends in Object Mode, and a timer goes back. For scripts
        Blender makes no step, and they expect the mode to stay: then the step is made here.
        """
        options = self.options
        is_of_user = options.is_invoke or options.is_repeat or options.is_repeat_last
        if obj.mode != "EDIT":
            yield
        elif is_of_user and not bpy.app.background:  # there, no timer runs
            bpy.ops.object.mode_set(mode="OBJECT")
            if goes_back:
                _go_back_to_edit_mode(obj)
            yield
        else:
            with object_mode(obj):
                yield
                undo_step.push(self.bl_label)


def is_edited(obj: bpy.types.Object) -> bool:
    """Whether it is in Edit Mode, or will be at once."""
    return bool(obj.mode == "EDIT" or obj.session_uid == _to_edit)


def _go_back_to_edit_mode(obj: bpy.types.Object) -> None:
    global _to_edit, _window
    _to_edit, _window = known.add(obj), bpy.context.window.as_pointer()
    bpy.app.timers.register(_enter, first_interval=0.0, persistent=True)


def _enter() -> None:
    global _to_edit
    obj, _to_edit = known.find(_to_edit), 0
    # Something else may have come first: an undo, another file, the end of the window.
    window = next((w for w in bpy.context.window_manager.windows if w.as_pointer() == _window), None)
    if obj is None or window is None or obj != window.view_layer.objects.active or obj.mode != "OBJECT":
        return
    with bpy.context.temp_override(window=window):  # a timer has the scene of the first one
        bpy.ops.object.mode_set(mode="EDIT")


def unregister() -> None:
    if bpy.app.timers.is_registered(_enter):
        bpy.app.timers.unregister(_enter)
