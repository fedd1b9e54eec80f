# SPDX-License-Identifier: GPL-3.0-or-later
"""Attach: the pictures of the user guide, and the README's, before and after one pull. Run by .ci/pictures."""

import subprocess
from pathlib import Path

import bpy
from camera import Camera, begin_pull, tidy_up
from harness import Steps, Ui
from test_pull import click, drag_to, press, release

SHOES = ((0.12, 0.0, 0.06), (-0.12, 0.0, 0.06))
TIP, END = (0.72, 0.0, 0.55), (0.92, 0.0, 1.40)  # of a hand
RADIUS = 18  # pixels: the tip alone, so that the hand turns with the arm
SIDE_PX = 640  # of each half of the README's picture
WITH_TAB = ("-gravity", "east", "-crop", "890x0+0+0", "+repage")  # pixels
MIDDLE = ("-gravity", "center", "-crop", "640x0+0+0", "+repage", "-resize", "75%")


def begin(ui: Ui) -> Steps:
    """The child seen from the front, both shoes pinned with a click; returns it."""
    child = yield from begin_pull(ui, "dressed")
    view = ui.view.spaces.active.region_3d
    view.view_distance *= 0.82
    view.view_location.x += 0.08
    yield
    for shoe in SHOES:
        yield from click(ui, shoe)
    ui.change_pull("radius", RADIUS)
    return child


def pull(ui: Ui, child: bpy.types.Object) -> Steps:
    """A hand, up and aside; ends when all that goes along has settled."""
    yield from press(ui, TIP)
    yield from drag_to(ui, END, 12)
    yield from ui.until(lambda: all(act.is_settled for act in ui.running.values()), "the mesh follows")
    yield from release(ui)
    name = child.data.shape_keys.key_blocks[-1].name
    worn = [attachment.object for attachment in child.arap.attachments]
    yield from ui.until(lambda: all(name in obj.data.shape_keys.key_blocks for obj in worn), "all go along")


def test_picture_attach(ui: Ui) -> Steps:
    """What goes along in the tab, and after a pull."""
    ui.open_panels("ARAP_PT_attach")
    camera = Camera(ui)
    child = yield from begin(ui)
    tidy_up(ui.view.spaces.active)
    yield from ui.open_tab()
    yield from ui.scroll_tab()
    yield from camera.area("guide-attach-1", *WITH_TAB)
    yield from pull(ui, child)
    yield from camera.view("guide-attach-2", *MIDDLE)


def test_picture_before_and_after_one_pull(ui: Ui) -> Steps:
    child = yield from begin(ui)
    halves = [render(ui, "before")]
    yield from pull(ui, child)
    halves.append(render(ui, "after"))
    subprocess.run(["convert", *halves, "+append", str(ui.screenshots / "attach.png")], check=True)
    for half in halves:
        Path(half).unlink()


def render(ui: Ui, name: str) -> str:
    """The studio of the scene."""
    settings = bpy.context.scene.render
    settings.resolution_x = settings.resolution_y = SIDE_PX
    settings.filepath = str(ui.screenshots / f"{name}.png")
    bpy.ops.render.render(write_still=True)
    return settings.filepath
