# SPDX-License-Identifier: GPL-3.0-or-later
"""Hostile files in a window: all panels are drawn, and the mouse goes over the mesh with ARAP Pull in hand.

A traceback that Blender prints fails the test: see harness.
"""

from collections.abc import Callable
from pathlib import Path

import bpy
import hostile
import scenes
import test_pull
from harness import Steps, Ui, sub_panels


def save_hostile(ui: Ui, make_hostile: Callable[[bpy.types.Object], None], path: Path) -> None:
    """A posed mesh that is live, while Follow sleeps, made hostile and saved."""
    obj = scenes.add_held_grid(ui.api)
    bpy.data.objects["Other Edge"].location.z += 0.4
    bpy.context.view_layer.update()
    ui.api.solve(obj)
    bpy.context.view_layer.objects.active = obj
    begin = ui.follow._begin
    ui.follow._begin = lambda *_, **__: None
    try:
        obj.arap.use_follow = True
        make_hostile(obj)
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
    finally:
        ui.follow._begin = begin


def test_hostile_files_are_drawn_and_pulled(ui: Ui) -> Steps:
    ui.open_panels(*(panel.__name__ for panel in sub_panels()))
    yield from test_pull.begin(ui)
    for make_hostile in hostile.KINDS:
        path = Path(bpy.app.tempdir) / f"{make_hostile.__name__}.blend"
        save_hostile(ui, make_hostile, path)
        ui.call(bpy.ops.wm.open_mainfile, "EXEC_DEFAULT", filepath=str(path))
        yield
        yield from ui.open_tab()
        obj = bpy.context.view_layer.objects.active
        run = ui.follow.run_of(obj)
        assert (run.is_settled, run.wants_timer, ui.sessions.get(obj.session_uid)) == (True, bool(run.pause), None)
        for place in ((0.2, 0.0, 0.2), (0.0, 0.3, 0.2)):
            yield from test_pull.point_at(ui, place)
            ui.view.tag_redraw()
            yield
        yield from ui.screenshot(make_hostile.__name__)
        obj.arap.use_follow = False
        yield from test_pull.press(ui, (0.0, 0.3, 0.2))
        ui.event("LEFTMOUSE", "RELEASE")
        yield from ui.until_free()
