# SPDX-License-Identifier: GPL-3.0-or-later
"""Attach in a window: bound in the background, along with a drag, through undo, and caught up when hidden."""

import bmesh
import bpy
import numpy as np
import scenes
from harness import Steps, Ui
from mathutils import Matrix
from test_follow import assert_followed, bar, begin, drag, settle

KEY = "ARAP"


def add_clothes() -> tuple[bpy.types.Object, bpy.types.Object]:
    """A band around the bar, and a button on it."""
    made = []
    for name, size, place in (
        ("Band", (1.2, 1.2, 1.0), (0.0, 0.0, 2.5)),
        ("Button", (0.2, 0.1, 0.2), (0.0, -0.65, 3.0)),
    ):
        mesh = bmesh.new()
        bmesh.ops.create_cube(mesh, size=1.0, matrix=Matrix.Diagonal((*size, 1.0)))
        if name == "Band":
            ends = [face for face in mesh.faces if abs(face.normal.z) > 0.5]
            bmesh.ops.delete(mesh, geom=ends, context="FACES_ONLY")
            bmesh.ops.subdivide_edges(mesh, edges=mesh.edges, cuts=3, use_grid_fill=True)
        data = bpy.data.meshes.new(name)
        mesh.to_mesh(data)
        mesh.free()
        obj = bpy.data.objects.new(name, data)
        obj.location = place
        bpy.context.scene.collection.objects.link(obj)
        made.append(obj)
    return made[0], made[1]


def band() -> bpy.types.Object:
    return bpy.data.objects["Band"]


def shift_of(obj: bpy.types.Object) -> float:
    """How far it has moved along x, on the average."""
    return float((scenes.shown_positions(obj) - scenes.key_positions(obj, "Basis")).mean(axis=0)[0])


def picture(ui: Ui, name: str) -> Steps:
    """Of the end of the tab, where the panel is."""
    yield from ui.scroll_tab()
    yield from ui.screenshot(name)
    yield from ui.move_mouse_to_view()


def test_clothes_go_along(ui: Ui) -> Steps:
    ui.open_panels("ARAP_PT_attach")
    yield from begin(ui)
    yield from ui.open_tab()
    yield from picture(ui, "0_none")
    ui.select(*add_clothes(), bar())
    assert ui.call(bpy.ops.arap.attach) == {"FINISHED"}
    assert [attachment.kind for attachment in bar().arap.attachments] == ["bend", "rigid"]
    bpy.ops.ed.undo_push(message="carry")
    ui.select(bpy.data.objects["Top"])
    yield from drag(ui)
    yield from settle(ui)
    yield from ui.until(lambda: shift_of(band()) > 0.3, "the band is bound and goes along")
    assert_followed(ui)
    yield from picture(ui, "1_followed")
    yield from ui.key("G")
    yield from ui.key("X")
    yield from ui.text("1")
    assert shift_of(band()) > 0.6, "during the drag, at once"
    yield from ui.key("ESC")
    yield from settle(ui)
    shown = shift_of(band())
    yield from ui.undo()
    yield from settle(ui)
    yield from ui.until(lambda: abs(shift_of(band())) < 1e-3, "undo")
    yield from ui.redo()
    yield from settle(ui)
    yield from ui.until(lambda: abs(shift_of(band()) - shown) < 1e-2, "redo")
    band().hide_set(True)
    yield from drag(ui)
    yield from settle(ui)
    yield from ui.until(lambda: shift_of(band()) > 1.5 * shown, "a hidden one catches up")
    band().hide_set(False)
    ui.select(band())
    bpy.ops.object.mode_set(mode="EDIT")
    bar().arap.active_attachment_index = 0
    ui.select(bar())
    yield from picture(ui, "2_edited")
    ui.select(band())
    bpy.ops.object.mode_set(mode="OBJECT")
    yield from picture(ui, "3_of_a_follower")
    assert abs(shift_of(band())) > 1.5 * shown, "it has not lost the pose"


def test_their_coordinates_are_right_when_a_script_solves(ui: Ui) -> Steps:
    """What is no frame of a motion waits for all."""
    scenes.add_bar_with_handle(ui.api)
    clothes = add_clothes()
    bpy.context.view_layer.update()
    ui.api.attach(bar(), clothes)
    bpy.data.objects["Top"].location.x += 1.0
    bpy.context.view_layer.update()
    ui.api.solve(bar())
    for obj in clothes:
        moved = scenes.key_positions(obj, KEY) - scenes.key_positions(obj, "Basis")
        assert np.abs(moved).max() > 0.2
    yield


def test_esc_ends_the_preparation_of_a_follower(ui: Ui) -> Steps:
    scenes.add_bar_with_handle(ui.api)
    made, _ = add_clothes()
    bpy.data.objects["Top"].location.x += 1.0
    bpy.context.view_layer.update()
    ui.api.solve(bar())
    ui.select(made, bar())
    with ui.held_stage():
        assert ui.call(bpy.ops.arap.attach) == {"FINISHED"}
        yield from ui.until(lambda: ui.waiting.shown() is not None, "the bar is drawn")
        assert ui.waiting.shown()[1].text.startswith("Preparing Band, ")
        yield from ui.key("ESC")
        yield from ui.until(lambda: not bar().arap.attachments[0].is_enabled, "it is switched off")
        yield from ui.until_no_bar()
    assert shift_of(band()) == 0.0
    bar().arap.attachments[0].is_enabled = True
    yield from ui.until(lambda: shift_of(band()) > 0.3, "it goes along")
