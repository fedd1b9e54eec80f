# SPDX-License-Identifier: GPL-3.0-or-later
"""The overlay in the 3D view, for the panel's mesh: pins, paths of the handles from rest, stretch as colour.

Batches are made after a change. Each redraw draws the same ones.
"""

from __future__ import annotations

from typing import Any

import bpy
import gpu
import numpy as np
from mathutils import Matrix

from ..core import sessions
from ..core.arrays import Float32s, Ints
from ..core.session_data import SolveStats
from ..props.bounds import bounded
from ..scene import known, meshes, pose_key, versions
from ..ui import batches
from ..ui.checks import find_drawn_object
from . import data
from .legend import draw_legend

PIN_SIZE = 5.0
REST_SIZE = 7.0
LINE_WIDTH = 1.5


class Drawn:
    """The batches of one object, and the data they were made from."""

    def __init__(self, surface: data.Surface) -> None:
        self.surface = surface
        self.indices = batches.index_buffer(surface.triangles)
        self.has_pinned = False  # whether ``pinned`` is up to date
        self.pinned: Ints = np.empty(0, dtype=np.int32)
        self._stamp: tuple[Any, ...] = ()
        self._readout: SolveStats | None = None
        self.heat: gpu.types.GPUBatch | None = None
        self.pins: gpu.types.GPUBatch | None = None
        self.lines: gpu.types.GPUBatch | None = None
        self.rests: gpu.types.GPUBatch | None = None
        self.cubes: gpu.types.GPUBatch | None = None
        self.ends: Float32s = np.empty((0, 3), dtype=np.float32)

    def update(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
        """Makes the batches that are out of date."""
        self._update_lines(obj, depsgraph)
        settings = obj.arap.overlay
        if settings.show_pins and not self.has_pinned and not versions.is_painting():
            self.pinned, self.has_pinned, self._stamp = data.read_pinned(obj), True, ()
        shows = (settings.show_strain, settings.show_pins, settings.show_cubes)
        stamp = (_changes, *shows, bounded(settings, "strain_limit"))
        if stamp == self._stamp and self.is_of(obj):
            return
        self._stamp, self._readout = stamp, sessions.stats(obj.session_uid)
        self.heat = self.pins = self.cubes = None
        if settings.show_cubes and len(edges := data.cube_edges(obj)):
            self.cubes = batches.plain_batch("LINES", edges)
        surface = self.surface
        if settings.show_strain or settings.show_pins:
            positions = data.positions_now(obj, surface, depsgraph)
        if settings.show_strain and len(surface.triangles):
            self.heat = batches.surface_batch(positions, data.strain_colors(obj, surface), self.indices)
        if settings.show_pins and len(self.pinned):
            self.pins = batches.plain_batch("POINTS", positions[self.pinned])

    def is_of(self, obj: bpy.types.Object) -> bool:
        """Whether the object was not solved after the batches were made."""
        return self._readout is sessions.stats(obj.session_uid)

    def _update_lines(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
        ends = data.handle_lines(obj, depsgraph) if obj.arap.overlay.show_handles else self.ends[:0]
        if np.array_equal(ends, self.ends):
            return
        self.ends = ends
        self.lines = batches.plain_batch("LINES", ends) if len(ends) else None
        self.rests = batches.plain_batch("POINTS", np.ascontiguousarray(ends[::2])) if len(ends) else None

    def draw(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
        matrix = obj.evaluated_get(depsgraph).matrix_world
        if self.heat is not None:
            batches.draw_surface(self.heat, matrix)
        if self.pins is not None:
            color = batches.color_of_pins()
            batches.draw_points(self.pins, matrix, color, PIN_SIZE, is_hidden_behind=True)
        if self.cubes is not None:
            batches.draw_plain(self.cubes, matrix, batches.color_of_cubes(), is_hidden_behind=False)
        if self.lines is not None and self.rests is not None:
            color = batches.color_of_handles()
            batches.draw_lines(self.lines, color, LINE_WIDTH)
            batches.draw_points(self.rests, Matrix(), color, REST_SIZE, is_hidden_behind=False)


_drawn: dict[int, Drawn] = {}
"""The last drawn object by its uid; one or none."""
_changes = 0  # counts evaluations that may have changed the drawn data


def shown_object(context: bpy.types.Context) -> bpy.types.Object | None:
    """The object whose overlay this view shows, None if there is none."""
    obj = find_drawn_object(context)
    if obj is None or not _shows_anything(obj) or obj.mode in {"EDIT", "SCULPT"} or obj.data.is_editmode:
        return None
    return obj


def _shows_anything(obj: bpy.types.Object) -> bool:
    overlay = obj.arap.overlay
    if not obj.arap.controls and pose_key.find(obj) is None:  # ARAP Pull needs neither
        return False
    return bool(overlay.show_pins or overlay.show_handles or overlay.show_strain or overlay.show_cubes)


def _draw_in_space() -> None:
    context = bpy.context
    obj = shown_object(context)
    if obj is None:
        return
    depsgraph = meshes.drawn_depsgraph(context)
    drawn = _drawn.get(obj.session_uid)
    if drawn is None or not drawn.surface.fits(obj):
        _drawn.clear()
        try:
            drawn = _drawn[known.add(obj)] = Drawn(data.Surface.read(obj, depsgraph))
        except ValueError:  # scaled to nothing, so it cannot be seen
            return
    drawn.update(obj, depsgraph)
    drawn.draw(obj, depsgraph)


def _draw_on_screen() -> None:
    obj = shown_object(bpy.context)
    if obj is not None and obj.arap.overlay.show_strain:
        draw_legend(bpy.context, bounded(obj.arap.overlay, "strain_limit"))


def updated(update: known.Update) -> None:
    """After an evaluation."""
    global _changes  # noqa: PLW0603 - counted by handlers, compared when drawing
    drawn = _drawn.get(update.uid)
    if drawn is None or not update.is_deformed:
        return
    _changes += 1
    if update.has_new_data and drawn.is_of(update.obj):
        # A change, but not by a solve: of faces, rest shape or groups.
        if update.obj.mode == "WEIGHT_PAINT":
            drawn.has_pinned = False  # only groups change, at each step of a stroke
        else:
            _drawn.clear()


def frame_changed() -> None:
    global _changes  # noqa: PLW0603 - as above
    _changes += 1


def forget() -> None:
    """After an undo or the load of a file."""
    _drawn.clear()


DRAWN = ((_draw_in_space, "POST_VIEW"), (_draw_on_screen, "POST_PIXEL"))


def unregister() -> None:
    forget()
