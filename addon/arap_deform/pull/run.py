# SPDX-License-Identifier: GPL-3.0-or-later
"""One drag of ARAP Pull: what is under the mouse, the posing act that follows it, and how it ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np

from ..core import sessions
from ..follow.act import End, Ending, Phase, PoseAct, print_fault, restored
from ..follow.scene import is_rendering
from ..live.runs import give_up
from ..pose.result import restore_state
from ..props import preferences
from ..scene import meshes, redraw
from ..ui.checks import StatusBar
from . import pins, seen_mesh
from .region import Grab, connected_within, symmetric_grabs
from .scene import PullScene
from .view import Drag, Mode, Pixels, View

TIMER_S = 0.01
MODES = {Mode.MOVE: "move", Mode.TURN: "turn", Mode.NORMAL: "normal"}


@dataclass(frozen=True)
class Grip:
    """Where the mouse has taken hold; no Blender data.

    Attributes:
        view, mouse: how the surface was seen, and the pixel.
        pick: what is there.
    """

    object_name: str
    view: View
    mouse: Pixels
    pick: seen_mesh.Pick


def find_grip(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    region: bpy.types.Region,
    region_data: bpy.types.RegionView3D,
    mouse: Pixels,
) -> Grip | None:
    """What of the mesh is under the mouse; None where it is not. Raises ValueError as seen_mesh.pick()."""
    view = seen_mesh.view_of(region, region_data)
    radius = context.window_manager.arap_pull.radius
    pick = seen_mesh.pick(obj, context.evaluated_depsgraph_get(), view, (mouse[0], mouse[1]), radius)
    return None if pick is None else Grip(obj.name, view, mouse, pick)


def grabs_at(obj: bpy.types.Object, pick: seen_mesh.Pick, falloff: float) -> list[Grab]:
    """What a drag takes hold of: the temporary pin that is there, or else the patch; and its mirror images.

    Raises:
        ValueError: the mesh has to be symmetric and is not.
    """
    there = pins.find(obj, pick.seeds)
    if there:
        pin = obj.arap.pull_pins[there[0]]
        return mirrored(obj, Grab(pin.vertices, pin.reach))
    return mirrored(obj, Grab(pick.vertices, falloff * pick.radius))


def mirrored(obj: bpy.types.Object, grab: Grab) -> list[Grab]:
    """The grab and its mirror images in the object's own planes, as the symmetry of its mesh says."""
    mesh = obj.data
    axes = (mesh.use_mirror_x, mesh.use_mirror_y, mesh.use_mirror_z)
    if not any(axes):
        return [grab]
    try:
        rest = meshes.read_rest(obj).astype(np.float64)
        return symmetric_grabs(rest, meshes.read_edges(obj), grab.vertices, grab.reach, axes)
    except ValueError as error:
        raise ValueError(f"'{obj.name}' {error}") from None


class PullRun:
    """One drag, from the first pixel until the mesh has settled."""

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object, grip: Grip) -> None:
        """Begins. Raises ValueError or RuntimeError where it cannot; then nothing has changed."""
        self.grip = grip
        self.drag = Drag(grip.view, grip.mouse, grip.pick.place, grip.pick.normal)
        self.is_released = False
        self.is_undone = False
        self._has_followed = False  # the last move of the mouse; no timer has come since
        give_up(obj)
        self.scene = PullScene(obj, grabs_at(obj, grip.pick, context.window_manager.arap_pull.falloff))
        self.act = PoseAct(self.scene, is_drag=True)
        self._seen = seen_mesh.read(obj, context.evaluated_depsgraph_get())
        self.act.begin()
        sessions.claim(obj.name, self.act)
        self._timer = context.window_manager.event_timer_add(TIMER_S, window=context.window)
        self._status = StatusBar()
        runs.append(self)

    def move(self, mouse: Pixels) -> None:
        self.drag.to(mouse)
        self.scene.motion = self.drag.motion
        self.act.unsettle()
        if not is_rendering():
            before = self.act.readout
            self.act.scene_changed()
            self._has_followed = self.act.readout is not before

    def tick(self) -> None:
        """To be called by a timer. A move has had its solve: refining in the same turn would hold up the next one."""
        has_followed, self._has_followed = self._has_followed, False
        if not has_followed and not is_rendering():
            self.act.tick(preferences.refine_time_s())

    def undone(self) -> None:
        """Undo or redo has brought another state of the scene: what this drag began with has gone."""
        self.is_undone = True
        self.act.leave("Undo has ended the pull")

    def resize(self, context: bpy.types.Context) -> None:
        """Takes hold anew with the present radius. A ValueError of that ends the drag as any other."""
        obj = self.scene.obj
        pick = self.grip.pick
        if obj is None or pins.find(obj, pick.seeds):
            return  # a pin has its size
        settings = context.window_manager.arap_pull
        radius = settings.radius * self.grip.view.pixel_size(pick.place)
        edges = self._seen.topology.edges
        vertices = connected_within(self._seen.positions, edges, pick.seeds, pick.place, radius)
        self.act.unsettle()
        try:
            self.scene.grab(mirrored(obj, Grab(vertices, settings.falloff * radius)))
        except ValueError as error:
            self.act.fail(error)

    @property
    def is_over(self) -> bool:
        """Released and settled, or ended otherwise."""
        if self.act.end is None and self.is_released and self.act.phase is Phase.FOLLOWING and self.act.is_settled:
            self.act.keep(is_settling=False)
        return self.act.end is not None

    def show_status(self, context: bpy.types.Context) -> None:
        self._status.show(context, status_text(self.act, self.drag, is_released=self.is_released))

    def finish(self) -> End:
        """The one exit of all ends; ``end.message`` is what is left to say."""
        end = self.act.end
        assert end is not None
        runs.remove(self)
        bpy.context.window_manager.event_timer_remove(self._timer)
        sessions.release(self.scene.name, self.act)
        obj = self.scene.obj
        if obj is None:
            sessions.drop(self.scene.name)
        elif end.how is Ending.RESTORE:
            end = restored(end, lambda: restore_state(obj, self.scene.state))
        elif end.how is Ending.KEEP:
            pins.add(obj, self.scene.pull.grabs)
        self._status.clear()
        print_fault(end)
        redraw.tag_panels()
        return end


runs: list[PullRun] = []
"""The drags under way: one, and those that settle after it."""


def status_text(act: PoseAct, drag: Drag, *, is_released: bool) -> str:
    """What the status bar says: state, then keys."""
    if act.phase is Phase.BINDING:
        return f"ARAP Pull: preparing the mesh, {act.bind_fraction:.0%}   |   Esc: cancel"
    if is_released:
        return "ARAP Pull: settling"
    axis = "free" if drag.axis is None else "along {}".format("XYZ"[drag.axis])
    text = (
        "ARAP Pull: {}, {}   |   Shift: turn   |   Ctrl: along the normal   |   X, Y, Z: axis   |   Wheel: radius"
        "   |   Esc: cancel"
    )
    return text.format(MODES[drag.mode], axis)


def remove_pins_at(obj: bpy.types.Object, pick: seen_mesh.Pick) -> bool:
    """Removes the temporary pins under the mouse and, with symmetry, their images; whether there were any."""
    vertices = np.union1d(pick.vertices, pick.seeds).astype(np.int32)
    images: Sequence[Grab] = mirrored(obj, Grab(vertices)) if pins.find(obj, vertices) else ()
    found = {index for grab in images for index in pins.find(obj, grab.vertices)}
    pins.remove(obj, sorted(found))
    return bool(found)
