# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the user guide: each panel, the first pose, what is drawn over the mesh. Run by .ci/pictures."""

import bpy
import numpy as np
from camera import Camera, begin_pull, look, open_creature, tidy_up
from harness import Steps, Ui
from mathutils import Vector
from test_overlay import show_all

FRAME = 24  # of the creature's animation: it looks aside, a paw up
MIDDLE = ("-gravity", "center", "-crop", "690x0-60+0", "+repage", "-resize", "50%")
PANELS = {
    "entry": ("ARAP_PT_entry",),
    "stiffness": ("ARAP_PT_stiffness",),
    "poses": ("ARAP_PT_poses",),
    "bake": ("ARAP_PT_bake",),
    "show": ("ARAP_PT_display",),
    "settings": ("ARAP_PT_advanced",),
}


def posed_creature(ui: Ui) -> Steps:
    """The sample creature, solved in a frame of its animation; returns it."""
    creature = yield from open_creature(ui)
    bpy.context.scene.frame_set(FRAME)
    assert ui.call(bpy.ops.arap.solve, "EXEC_DEFAULT", True) == {"FINISHED"}
    return creature


def bare_creature(ui: Ui) -> Steps:
    """The sample creature as nobody has posed it yet; returns it."""
    creature = yield from begin_pull(ui)
    ui.call(bpy.ops.wm.tool_set_by_id, "EXEC_DEFAULT", True, name="builtin.select_box")
    return creature


def group(creature: bpy.types.Object, name: str) -> np.ndarray:
    index = creature.vertex_groups[name].index
    return np.array([v.index for v in creature.data.vertices if index in {g.group for g in v.groups}])


def select_in_edit_mode(ui: Ui, creature: bpy.types.Object, *groups: np.ndarray) -> None:
    bpy.ops.object.mode_set(mode="OBJECT")
    ui.meshes.select_vertices(creature, np.concatenate(groups), shows_hidden=True)
    bpy.ops.object.mode_set(mode="EDIT")


def test_picture_tab(ui: Ui) -> Steps:
    bpy.context.preferences.view.ui_scale = 0.8  # so that most of the tab is in the picture
    camera = Camera(ui)
    yield from posed_creature(ui)
    yield from ui.open_tab()
    look(ui, right=-0.6, up=0.3)
    yield from camera.area("guide-tab")


def test_picture_panels(ui: Ui) -> Steps:
    camera = Camera(ui)
    creature = yield from posed_creature(ui)
    ui.api.add_stiffness(creature, group(creature, "Tail"), name="Brush", factor=10.0)
    ui.api.add_rigid(creature, group(creature, "Head"), name="Skull")
    ui.api.store_pose(creature, "Look Aside")
    ui.api.store_pose(creature, "Paw Up")
    creature.arap.overlay.show_pins = creature.arap.overlay.show_strain = True
    yield from camera.open_panels()
    for name, panels in PANELS.items():
        yield from camera.panel(f"guide-panel-{name}", *panels)
    assert creature.arap.follow_error == ""


def test_picture_first_pose(ui: Ui) -> Steps:
    """What the steps do in the view, and the tab after them."""
    camera = Camera(ui)
    creature = yield from bare_creature(ui)
    tidy_up(ui.view.spaces.active)
    paws = [group(creature, name) for name in ("Paw front R", "Paw hind L", "Paw hind R")]
    paw = group(creature, "Paw front L")
    creature.vertex_groups.clear()
    look(ui, right=-0.6, up=0.3, closer=0.8)
    select_in_edit_mode(ui, creature, *paws)
    yield from camera.view("guide-first-pose-1", *MIDDLE)
    assert ui.call(bpy.ops.arap.pin_add) == {"FINISHED"}
    select_in_edit_mode(ui, creature, paw)
    assert ui.call(bpy.ops.arap.handle_add) == {"FINISHED"}
    empty = creature.arap.handles[0].target
    yield from camera.view("guide-first-pose-2", *MIDDLE)
    yield from ui.until(lambda: ui.follow.run_of(creature).is_settled, "it is bound")
    empty.location += Vector((0.05, -0.35, 0.35))
    empty.rotation_euler.x = -1.0
    yield
    yield from ui.until(lambda: ui.follow.run_of(creature).is_settled, "the mesh follows")
    yield from camera.view("guide-first-pose-3", *MIDDLE)
    yield from ui.open_tab()
    yield from camera.panel("guide-panel-posing")


def test_picture_overlay(ui: Ui) -> Steps:
    camera = Camera(ui)
    creature = yield from posed_creature(ui)
    tidy_up(ui.view.spaces.active)
    show_all(creature)
    look(ui, right=-0.5, up=0.25, closer=0.85)
    yield from camera.view("guide-overlay")


def test_picture_dialog(ui: Ui) -> Steps:
    camera = Camera(ui)
    yield from posed_creature(ui)
    tidy_up(ui.view.spaces.active)
    yield from ui.move_mouse_to_view()
    yield from camera.popup("guide-bake-animation", bpy.ops.arap.bake_animation, use_fewest_keys=True)
    yield from ui.key("ESC")


def test_picture_preferences(ui: Ui) -> Steps:
    camera = Camera(ui)
    area = yield from ui.turn_view_into_preferences()
    yield from camera.area("guide-preferences", "-crop", "886x104+170+254", "+repage", area=area)
