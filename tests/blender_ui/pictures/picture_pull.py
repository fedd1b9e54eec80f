# SPDX-License-Identifier: GPL-3.0-or-later
"""ARAP Pull: the README's moving picture, frame_000.png and so on, and the pictures of the user guide.

The sample creature, pinned with two clicks and pulled by an ear and its head. Run by .ci/pictures.
"""

import shutil

import bpy
import numpy as np
from camera import Camera, begin_pull, tidy_up
from harness import Steps, Ui
from test_pull import click, drag_to, point_at, press, release

N_FRAMES = 12  # of a drag
HOLD = 6
MIDDLE = ("-gravity", "center", "-crop", "640x0+0+0", "+repage")  # pixels
EAR, EAR_END = (0.42, 0.0, 1.6), (0.75, 0.0, 1.45)
NOSE, NOSE_END = (0.0, 0.0, 1.0), (0.22, 0.0, 1.15)


class Film:
    """Takes the frames."""

    def __init__(self, ui: Ui) -> None:
        self._ui = ui
        self._camera = Camera(ui, has_soft_edges=False)
        self._n = 0

    def frame(self, n_times: int = 1) -> Steps:
        folder, first = self._ui.screenshots, f"frame_{self._n:03d}"
        yield from self._camera.view(first, *MIDDLE)
        for i in range(1, n_times):
            shutil.copy(folder / f"{first}.png", folder / f"frame_{self._n + i:03d}.png")
        self._n += n_times

    def drag(self, start: tuple[float, float, float], end: tuple[float, float, float]) -> Steps:
        """Slow at both ends, as a hand is."""
        ui = self._ui
        yield from press(ui, start)
        for i in range(1, N_FRAMES + 1):
            part = (1 - np.cos(np.pi * i / N_FRAMES)) / 2
            yield from drag_to(ui, tuple(np.array(start) + part * (np.array(end) - np.array(start))), 1)
            yield from ui.until(lambda: all(act.is_settled for act in ui.running.values()), "the mesh follows")
            yield from self.frame()
        yield from release(ui)
        yield from self.frame(HOLD)


def begin(ui: Ui) -> Steps:
    """The creature from near, the tool in hand and nothing beside it; returns it."""
    creature = yield from begin_pull(ui)
    tidy_up(ui.view.spaces.active)
    ui.call(bpy.ops.view3d.view_selected)
    view = ui.view.spaces.active.region_3d
    view.view_distance *= 0.68
    view.view_location.z += 0.02
    yield
    creature.data.use_mirror_x = True
    return creature


def pin(ui: Ui, film: Film | None = None) -> Steps:
    """A paw and a shoulder, and what mirrors them."""
    for height in (0.05, 0.6):
        yield from click(ui, (0.2, 0.0, height))
        if film is not None:
            yield from film.frame(HOLD // 2)


def test_picture_pull(ui: Ui) -> Steps:
    creature = yield from begin(ui)
    film = Film(ui)
    yield from film.frame(HOLD)
    yield from pin(ui, film)
    yield from film.drag(EAR, EAR_END)
    creature.data.use_mirror_x = False
    yield from film.drag(NOSE, NOSE_END)
    assert creature.data.shape_keys is not None


def test_picture_pull_in_the_guide(ui: Ui) -> Steps:
    """The patch under the mouse, and a drag."""
    camera = Camera(ui)
    yield from begin(ui)
    yield from pin(ui)
    yield from point_at(ui, EAR)
    yield from camera.view("guide-pull-1", *MIDDLE, "-resize", "60%")
    yield from press(ui, EAR)
    yield from drag_to(ui, EAR_END)
    yield from ui.until(lambda: all(act.is_settled for act in ui.running.values()), "the mesh follows")
    yield from camera.view("guide-pull-2", *MIDDLE, "-resize", "60%")
    yield from release(ui)
