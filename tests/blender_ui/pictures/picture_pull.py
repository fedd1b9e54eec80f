# SPDX-License-Identifier: GPL-3.0-or-later
"""ARAP Pull: the README's moving picture, frame_000.png and so on, and the pictures of the user guide.

The moving picture begins with a figure that nobody has touched: a button, then three drags. The guide's pictures show
the sample creature, pinned with two clicks and pulled by an ear. Run by .ci/pictures.
"""

import shutil
import subprocess

import bpy
import numpy as np
from camera import Camera, begin_pull, look, tidy_up
from harness import Steps, Ui
from test_pull import Place, click, drag_to, point_at, press, release

N_FRAMES = 12  # of a drag
N_WAY = 5  # of the mouse on its way
HOLD = 8
MIDDLE = ("-gravity", "center", "-crop", "640x0+0+0", "+repage")  # pixels
EAR, EAR_END = (0.42, 0.0, 1.6), (0.75, 0.0, 1.45)
DRAGS = (  # a paw, the tail, an ear
    ((0.28, -0.36, 0.06), (0.28, -0.72, 0.36)),
    ((0.06, 0.8, 1.48), (0.06, 1.1, 1.1)),
    ((0.5, -0.55, 1.7), (0.5, -0.22, 1.6)),
)
POINTER = np.array([(0, 0), (0, 17), (4, 13), (7, 19), (9, 18), (6, 12), (12, 12)])  # pixels


class Film:
    """Takes the frames: the 3D view with its sidebar, and the mouse."""

    def __init__(self, ui: Ui) -> None:
        self._ui = ui
        self._camera = Camera(ui, has_soft_edges=False)
        self._n = 0

    def frame(self, n_times: int = 1) -> Steps:
        folder, first = self._ui.screenshots, f"frame_{self._n:03d}"
        yield from self._camera.area(first)
        self._draw_mouse(f"{folder}/{first}.png")
        for i in range(1, n_times):
            shutil.copy(folder / f"{first}.png", folder / f"frame_{self._n + i:03d}.png")
        self._n += n_times

    def _draw_mouse(self, path: str) -> None:
        """A picture of a window does not have it."""
        area = self._ui.view
        tip = np.array([self._ui.mouse[0] - area.x, area.y + area.height - self._ui.mouse[1]])
        corners = " ".join(f"{x},{y}" for x, y in tip + POINTER)
        colours = ("-fill", "white", "-stroke", "black")
        subprocess.run(["convert", path, *colours, "-draw", f"polygon {corners}", path], check=True)

    def go(self, pixel: tuple[int, int]) -> Steps:
        """The mouse on its way, no button down."""
        start, end = np.array(self._ui.mouse), np.array(pixel)
        for part in np.linspace(0.0, 1.0, N_WAY + 1)[1:]:
            x, y = start + part * (end - start)
            yield from self._ui.move_mouse(round(x), round(y))
            yield from self.frame()

    def drag(self, start: Place, end: Place) -> Steps:
        """Slow at both ends, as a hand is."""
        ui = self._ui
        yield from self.go(ui.pixel(start))
        yield from self.frame(HOLD // 2)
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


def pin(ui: Ui) -> Steps:
    """A paw and a shoulder, and what mirrors them."""
    for height in (0.05, 0.6):
        yield from click(ui, (0.2, 0.0, height))


def test_picture_first_drags(ui: Ui) -> Steps:
    """From a figure that nobody has touched to a pose."""
    film = Film(ui)
    creature = yield from begin_pull(ui)
    ui.call(bpy.ops.wm.tool_set_by_id, "EXEC_DEFAULT", True, name="builtin.select_box")
    tidy_up(ui.view.spaces.active)
    yield from ui.open_tab()
    look(ui, right=-0.6, up=0.3, closer=0.8)
    yield from film.frame(HOLD)
    yield from film.go(button_at(ui))
    assert ui.call(bpy.ops.arap.pull_tool) == {"FINISHED"}
    yield from film.frame(HOLD)
    for start, end in DRAGS:
        yield from film.drag(start, end)
    yield from film.frame(HOLD)
    assert creature.data.shape_keys is not None


def button_at(ui: Ui) -> tuple[int, int]:
    """The middle of the first button of the tab."""
    region = ui.region("UI")
    return region.x + region.width // 3, region.y + region.height - 156


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
