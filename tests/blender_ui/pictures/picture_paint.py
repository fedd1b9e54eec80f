# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of the user guide: a pin that is painted on the live creature. Run by .ci/pictures."""

import bpy
from camera import Camera, look, open_creature
from harness import Steps, Ui
from mathutils import Vector
from test_weight_paint import paint

STROKE = ((0.0, -0.15, 0.62), (0.0, 0.5, 0.62))  # along the flank, as seen from the creature's left


def test_picture_paint(ui: Ui) -> Steps:
    camera = Camera(ui)
    creature = yield from open_creature(ui)
    bpy.context.scene.frame_set(24)
    space = ui.view.spaces.active
    space.show_region_toolbar = space.show_gizmo = False
    look(ui, closer=0.85)
    creature.vertex_groups.new(name="Back")
    ui.api.add_pin_group(creature, "Back")
    creature.arap.use_follow = True
    yield from ui.until(lambda: ui.follow.run_of(creature).is_settled, "Follow settles")
    yield from paint(ui, "Back", creature)
    yield from stroke(ui)
    yield from ui.until(lambda: ui.follow.run_of(creature).is_settled, "the mesh follows")
    yield from camera.area("guide-paint")


def stroke(ui: Ui) -> Steps:
    start, end = map(Vector, STROKE)
    for share in range(11):
        yield from ui.move_mouse(*ui.pixel(start.lerp(end, share / 10)))
        if share == 0:
            ui.event("LEFTMOUSE", "PRESS")
            yield
    ui.event("LEFTMOUSE", "RELEASE")
    yield
