# SPDX-License-Identifier: GPL-3.0-or-later
"""The LiveScene of an object in Blender: when it pauses, and how Live is switched off."""

from __future__ import annotations

import math

import bpy

from ..core import sessions
from ..follow.act import print_fault
from ..follow.mesh import SessionBinding
from ..follow.scene import BlenderFollowScene
from ..scene import meshes, pose_key
from .run import NotNow

PAUSING_MODES = {"EDIT": "Edit Mode", "SCULPT": "Sculpt Mode"}


class BlenderLiveScene(BlenderFollowScene):
    """Reads from the depsgraph of the handler that runs, or of the window that shows the object."""

    key: pose_key.KeyFollower
    _lack = ""  # why it cannot follow while weights are painted; the next stroke may change that

    def __init__(self, obj: bpy.types.Object) -> None:
        super().__init__(obj)
        self.key = pose_key.KeyFollower(obj)

    def why_paused(self) -> str:
        obj = self._obj()
        act = sessions.claimed_by(self.name)
        if act:
            return f"Paused while {act}"
        self._follow_key(obj)  # in every mode: keys can be renamed in Edit Mode too
        if self._lack and self._is_in_weight_paint():
            return self._lack
        if obj.mode in PAUSING_MODES or obj.data.is_editmode:
            return "Paused in {}".format(PAUSING_MODES.get(obj.mode, "Edit Mode"))
        if not meshes.is_evaluated(obj, self._depsgraph()):
            return "Paused: this mesh is disabled, excluded or in another scene"
        return ""

    def _note_change(self, depsgraph: bpy.types.Depsgraph) -> None:
        super()._note_change(depsgraph)
        self._lack = ""

    def _follow_key(self, obj: bpy.types.Object) -> None:
        reason = self.key.why_left(obj)
        if reason:
            raise ValueError(reason)  # else both keys would show the pose
        self.key.follow(obj)  # if it was removed, the next pose makes a new one

    def look_again(self) -> None:
        self._is_suspect = True

    def undone(self) -> None:
        self.key.forget_address()
        self.look_again()

    def begin_bind(self) -> SessionBinding:
        try:
            binding = super().begin_bind()
        except ValueError as error:
            if not self._is_in_weight_paint():
                raise
            self._lack = f"Paused: {error}"
            raise NotNow(self._lack) from None
        if bpy.app.background:  # there are no timers, so wait for it
            binding.step(math.inf)
        return binding

    def switch_off(self, error: Exception) -> None:
        print_fault(error)
        obj = self.obj
        if obj is not None:
            obj.arap.is_live = False
            obj.arap.live_problem = f"{error}: Live is off"
            if bpy.app.background:
                print(f"ARAP: {obj.arap.live_problem}")

    def _depsgraph(self) -> bpy.types.Depsgraph:
        if self.depsgraph is not None:
            return self.depsgraph
        for window in bpy.context.window_manager.windows:
            if window.scene != bpy.context.scene and window.view_layer.objects.get(self.name) == self.obj:
                window.view_layer.update()
                return window.view_layer.depsgraph
        return super()._depsgraph()
