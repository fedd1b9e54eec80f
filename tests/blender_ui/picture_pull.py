# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of the README's moving picture: the sample creature, pinned with two clicks and pulled by an ear and its head.

Run by .ci/pictures with run.py --files "picture_*.py"; frame_000.png and so on in the folder of the screenshots.
"""

import subprocess

import bpy
import numpy as np
from harness import Steps, Ui
from test_pull import begin_creature, click, drag_to, press, release

N_FRAMES = 12  # of a drag
HOLD = 6


class Camera:
    """Takes the frames."""

    def __init__(self, ui: Ui) -> None:
        self._ui = ui
        self._n = 0

    def frame(self, n_times: int = 1) -> Steps:
        for _ in range(12):
            yield
        region, window = self._ui.region(), self._ui.window
        crop = f"{region.width}x{region.height}+{region.x}+{window.height - region.y - region.height}"
        for _ in range(n_times):
            path = self._ui.screenshots / f"frame_{self._n:03d}.png"
            subprocess.run(["import", "-window", "root", "-crop", crop, "+repage", str(path)], check=True)
            self._n += 1

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


def tidy_up(space: bpy.types.SpaceView3D) -> None:
    space.show_region_toolbar = space.show_region_header = space.show_region_tool_header = False
    space.show_gizmo = False
    overlay = space.overlay
    overlay.show_floor = overlay.show_axis_x = overlay.show_axis_y = overlay.show_cursor = overlay.show_text = False
    overlay.show_outline_selected = overlay.show_ortho_grid = overlay.show_object_origins = False


def test_picture_pull(ui: Ui) -> Steps:
    creature = yield from begin_creature(ui)
    tidy_up(ui.view.spaces.active)
    ui.call(bpy.ops.view3d.view_selected)
    view = ui.view.spaces.active.region_3d
    view.view_distance *= 0.6
    view.view_location.z += 0.1
    yield
    camera = Camera(ui)
    creature.data.use_mirror_x = True
    yield from camera.frame(HOLD)
    for height in (0.05, 0.6):
        yield from click(ui, (0.2, 0.0, height))
        yield from camera.frame(HOLD // 2)
    yield from camera.drag((0.42, 0.0, 1.6), (0.75, 0.0, 1.45))
    creature.data.use_mirror_x = False
    yield from camera.drag((0.0, 0.0, 1.0), (0.22, 0.0, 1.15))
    assert creature.data.shape_keys is not None
