# SPDX-License-Identifier: GPL-3.0-or-later
"""What the interaction needs of Blender, for one object. No references: undo replaces all data."""

from __future__ import annotations

import bpy

from ..core import sessions
from ..core.session_input import SessionInput
from ..engine import ready
from ..engine.scene import BlenderEngineScene
from ..scene import known, pose_key
from ..scene.snapshot import counts_of
from . import undo
from .result import capture_state, restore_state


class InteractionScene(BlenderEngineScene):
    """The EngineScene of an interaction that can put everything back."""

    task_name = "posing"  # for messages
    modes = {"OBJECT"}

    def __init__(self, obj: bpy.types.Object) -> None:
        super().__init__(obj)
        pose_key.forget_removed(obj)
        self._state = capture_state(obj)
        self._counts = counts_of(obj)

    def _why_not(self, obj: bpy.types.Object | None) -> str:
        if obj is None or not known.is_in(bpy.context.scene, obj):
            reason = f"'{self.name}' was deleted"
        elif obj.mode not in self.modes:
            reason = f"'{self.name}' is no longer in Object Mode"
        elif counts_of(obj) != self._counts:
            reason = f"The mesh of '{self.name}' has changed"
        else:
            reason = self._why_over(obj)
        return f"{reason}: {self.task_name} has ended" if reason else ""

    def restore(self, obj: bpy.types.Object) -> None:
        """Puts everything back to where it was before the interaction. Raises as restore_state()."""
        restore_state(obj, self._state)

    def _why_over(self, _obj: bpy.types.Object) -> str:
        """Other reasons why an interaction of this kind cannot go on, without a full stop."""
        return ""


class BlenderPoseScene(InteractionScene):
    """The EngineScene of Pose."""

    modes = {"OBJECT", "WEIGHT_PAINT"}
    key: pose_key.KeyTracker

    def __init__(self, obj: bpy.types.Object) -> None:
        """Raises ValueError if a pose would be for nothing."""
        ready.check(obj, bpy.context.evaluated_depsgraph_get())
        super().__init__(obj)
        self.act_number = 0
        self.key = pose_key.KeyTracker(obj)
        former = sessions.get(obj.session_uid)
        self._topology = former.inputs.signature.topology if former is not None else None

    @property
    def obj(self) -> bpy.types.Object | None:
        """The object; None if it is gone, or as it was before the interaction."""
        obj = super().obj
        return obj if obj is not None and undo.is_within(obj, self.act_number) else None

    def restore(self, obj: bpy.types.Object) -> None:
        self.key.give_name_back(obj)
        super().restore(obj)

    def _why_over(self, obj: bpy.types.Object) -> str:
        try:
            is_removed = self.key.track(obj) is None
        except ValueError as error:
            return str(error)
        return f"Shape key '{pose_key.wanted_name(obj)}' of '{obj.name}' was removed" if is_removed else ""

    def _read_inputs(self) -> SessionInput:
        inputs = super()._read_inputs()
        topology = inputs.signature.topology
        if self._topology not in {None, topology}:
            raise ValueError(f"The faces of '{self.name}' have changed")
        self._topology = topology
        return inputs
