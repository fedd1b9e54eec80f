# SPDX-License-Identifier: GPL-3.0-or-later
"""One drag of ARAP Pull: the piece under the mouse, the interaction that follows the mouse, and its end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import bpy
import numpy as np

from ..core.arrays import Ints
from ..core.native import ERRORS
from ..engine.interaction import End, Ending, Interaction, Phase
from ..engine.scene import is_rendering
from ..follow.runs import clear_follow_error
from ..pose.run import InteractionRun
from ..props import preferences
from ..props.bounds import bounded
from ..scene import known, meshes, versions
from . import evaluated_mesh, pins
from .drag import Drag, Mode
from .region import PulledPatch, connected_within, symmetric_grabs
from .scene import PullScene
from .view import Pixels, View

TIMER_S = 0.01
FOLLOW_OFF = "Follow is off, so the mesh keeps what you pulled. To go on, press Make Handles and tick Follow"
MODES = {Mode.MOVE: "move", Mode.TURN: "turn", Mode.NORMAL: "normal"}


@dataclass(frozen=True)
class DragStart:
    """The place that the mouse drags; no Blender data.

    Attributes:
        uid: of the mesh.
        view, mouse: the view and the pixel at the press.
        pick: the surface there.
    """

    uid: int
    view: View
    mouse: Pixels
    pick: evaluated_mesh.PickedPatch


def find_grip(context: bpy.types.Context, obj: bpy.types.Object, mouse: tuple[float, float]) -> DragStart | None:
    """The grip under the mouse; None if the mesh is not there. Raises ValueError as evaluated_mesh.pick()."""
    view = evaluated_mesh.view_of(context.region, context.region_data)
    radius = preferences.pull().radius
    pick = evaluated_mesh.pick(obj, context.evaluated_depsgraph_get(), view, mouse, radius)
    return None if pick is None else DragStart(known.add(obj), view, mouse, pick)


def grabs_at(obj: bpy.types.Object, pick: evaluated_mesh.PickedPatch, patch: PulledPatch) -> list[PulledPatch]:
    """The temporary pin at the place, else the patch; then its mirror images. Raises ValueError as mirrored()."""
    there = pins.find(obj, pick.seeds)
    return mirrored(obj, pins.grabs_of(obj)[there[0]] if there else patch)


def patch_of(vertices: Ints, radius: float) -> PulledPatch:
    """A patch of this radius that is dragged, with the reach of the settings."""
    settings = preferences.pull()
    return PulledPatch(vertices, bounded(settings, "reach") * radius, None if settings.use_auto_reach else 0.0)


def mirrored(obj: bpy.types.Object, grab: PulledPatch) -> list[PulledPatch]:
    """The grab, and its mirror images if the mesh has symmetry turned on. Raises ValueError if it is not symmetric."""
    mesh = obj.data
    axes = (mesh.use_mirror_x, mesh.use_mirror_y, mesh.use_mirror_z)
    if not any(axes):
        return [grab]
    try:
        rest = meshes.read_rest(obj).astype(np.float64)
        return symmetric_grabs(rest, versions.read_edges(obj.data), grab, axes)
    except ValueError as error:
        raise ValueError(f"'{obj.name}' {error}") from None


class PullRun(InteractionRun):
    """One drag, from the first move of the mouse until the mesh has settled."""

    scene: PullScene

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object, grip: DragStart) -> None:
        """Begins. Raises ValueError or RuntimeError if it cannot; then nothing has changed."""
        self.grip = grip
        self.is_released = False
        self.is_undone = False
        self._was_following = bool(obj.arap.use_follow)
        self._has_followed = False  # the mesh has followed a move of the mouse since the last tick
        clear_follow_error(obj)
        scene = PullScene(obj, grabs_at(obj, grip.pick, patch_of(grip.pick.vertices, grip.pick.radius)))
        self.drag = Drag(grip.view, grip.mouse, grip.pick.place, grip.pick.normal, scene.lever)
        self.drag.is_turning_along = preferences.pull().use_turn
        self._seen = evaluated_mesh.read(obj, context.evaluated_depsgraph_get())
        interaction = Interaction(scene, is_drag=True)
        interaction.begin()
        super().__init__(context, scene, interaction, TIMER_S)
        runs.append(self)

    def move(self, mouse: Pixels) -> None:
        self.drag.to(mouse)
        self.scene.motion = self.drag.motion
        self.interaction.unsettle()
        if not is_rendering():
            before = self.interaction.stats
            self.interaction.scene_changed()
            self._has_followed = self.interaction.stats is not before

    def tick(self) -> None:
        """For a timer. After a move there is no refining in the same turn: it would hold up the next move."""
        has_followed, self._has_followed = self._has_followed, False
        if not has_followed and not is_rendering():
            self.step()

    def undone(self) -> None:
        """Undo or redo has replaced the scene in which this drag began."""
        self.is_undone = True
        self.interaction.leave("Undo has ended the pull")

    def resize(self) -> None:
        """Drags a patch of the present radius. An error ends the drag."""
        obj = self.scene.obj
        pick = self.grip.pick
        if obj is None or pins.find(obj, pick.seeds):
            return  # a pin keeps its size
        settings = preferences.pull()
        radius = settings.radius * self.grip.view.pixel_size(pick.place)
        edges = self._seen.topology.edges
        self.interaction.unsettle()
        try:
            vertices = connected_within(self._seen.positions, edges, pick.seeds, pick.place, radius)
            self.scene.grab(mirrored(obj, patch_of(vertices, radius)))
            self.drag.lever = self.scene.lever
        except ERRORS as error:
            self.interaction.fail(error)

    @property
    def is_over(self) -> bool:
        """Whether the drag is released and settled, or has ended otherwise."""
        if (
            self.interaction.end is None
            and self.is_released
            and self.interaction.phase is Phase.FOLLOWING
            and self.interaction.is_settled
        ):
            self.interaction.keep(is_settling=False)
        return self.interaction.end is not None

    def show_status(self, context: bpy.types.Context) -> None:
        self.show_text(context, self._status_text())

    def finish(self) -> End:
        runs.remove(self)
        end = super().finish()
        obj = self.scene.obj
        if end.how is Ending.KEEP and obj is not None:
            pins.add(obj, self.scene.pull.grabs)
            pins.remember_rest(obj, self.scene.pull.rest, self.scene.pull.shown)
            if self._was_following and obj.arap.use_follow:  # else it would take the mesh back to its handles
                obj.arap.use_follow = False
                end = replace(end, message=f"{end.message} {FOLLOW_OFF}".strip())
        return end

    def _status_text(self) -> str:
        if self.interaction.phase is Phase.BINDING:
            return f"ARAP Pull: preparing the mesh, {self.interaction.bind_fraction:.0%}   |   Esc: cancel"
        if self.is_released:
            return "ARAP Pull: settling"
        if self.drag.is_beyond:
            return "ARAP Pull: this is as far as it reaches   |   Alt: stretch it   |   Shift: turn   |   Esc: cancel"
        axis = "free" if self.drag.axis is None else f"along {'XYZ'[self.drag.axis]}"
        return (
            f"ARAP Pull: {MODES[self.drag.mode]}, {axis}   |   Shift: turn   |   Ctrl: along the normal   |   "
            "X, Y, Z: axis   |   Alt: stretch   |   Wheel: radius   |   Esc: cancel"
        )


runs: list[PullRun] = []
"""The drag under way, and earlier ones that still settle."""


def remove_pins_at(obj: bpy.types.Object, pick: evaluated_mesh.PickedPatch) -> bool:
    """Removes the temporary pins under the mouse and, with symmetry, their images; returns whether there were any."""
    vertices = np.union1d(pick.vertices, pick.seeds).astype(np.int32)
    images: Sequence[PulledPatch] = mirrored(obj, PulledPatch(vertices)) if pins.find(obj, vertices) else ()
    found = {index for grab in images for index in pins.find(obj, grab.vertices)}
    pins.remove(obj, sorted(found))
    return bool(found)
