# SPDX-License-Identifier: GPL-3.0-or-later
"""Make Stand-in in a window: a figure in pieces is pulled as one, whichever piece is in hand. Clothes pull a host."""

import importlib

import bmesh
import bpy
import numpy as np
import scenes
from harness import MODULE, Steps, Ui
from mathutils import Matrix
from test_pull import click, grab, point_at, pull, refusal

PIECES = {  # colour, diameter, place of the middle, length, axis
    "Torso": ((0.8, 0.35, 0.3, 1), 1.2, (0.0, 0.0, 0.0), 3.0, "Z"),
    "Arm": ((0.35, 0.6, 0.8, 1), 0.5, (1.4, 0.0, 1.1), 2.2, "X"),
    "Hand": ((0.5, 0.75, 0.35, 1), 0.48, (2.9, 0.0, 1.1), 0.9, "X"),
    "Head": ((0.85, 0.75, 0.3, 1), 0.9, (0.0, 0.0, 2.0), 1.0, "Z"),
}


def add_figure() -> list[bpy.types.Object]:
    """A torso, an arm that begins in it, a hand over the arm's end, a head that stands on it."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    made = []
    for name, (color, diameter, place, length, axis) in PIECES.items():
        mesh = bmesh.new()
        turn = Matrix.Rotation(np.pi / 2, 4, "Y") if axis == "X" else Matrix()
        bmesh.ops.create_cone(
            mesh, cap_ends=True, segments=32, radius1=diameter / 2, radius2=diameter / 2, depth=length, matrix=turn
        )
        sides = [edge for edge in mesh.edges if edge.calc_length() > 0.9 * length]
        bmesh.ops.subdivide_edges(mesh, edges=sides, cuts=15)
        data = bpy.data.meshes.new(name)
        mesh.to_mesh(data)
        mesh.free()
        obj = bpy.data.objects.new(name, data)
        obj.location = place
        obj.color = color
        bpy.context.scene.collection.objects.link(obj)
        made.append(obj)
    bpy.context.view_layer.update()
    return made


def look_from_front(ui: Ui) -> Steps:
    """Along y: x to the right, z up."""
    space = ui.view.spaces.active
    space.shading.color_type = "OBJECT"
    region = space.region_3d
    region.view_perspective = "ORTHO"
    region.view_rotation = (0.7071068, 0.7071068, 0.0, 0.0)
    region.view_location = (2.2, 0.0, 0.7)  # left of the sidebar, and of the navigation gizmo
    region.view_distance = 10.0
    yield from ui.move_mouse_to_view()


def begin(ui: Ui) -> Steps:
    """The figure with a stand-in, its foot pinned, a piece active, and the tool."""
    made = add_figure()
    yield from look_from_front(ui)
    ui.select(*made)
    assert ui.call(bpy.ops.arap.stand_in_make) == {"RUNNING_MODAL"}
    yield from ui.until(lambda: "Stand-in" in bpy.data.objects, "the stand-in is made")
    yield
    assert bpy.context.object == stand_in()
    z = mesh_world(stand_in())[:, 2]
    ui.api.add_pin(stand_in(), np.flatnonzero(z < -1.3), name="Foot")
    ui.select(piece("Hand"))
    assert ui.call(bpy.ops.arap.pull_tool) == {"FINISHED"}
    ui.change_pull("radius", 25)
    bpy.ops.ed.undo_push(message="scene")
    yield


def stand_in() -> bpy.types.Object:
    return bpy.data.objects["Stand-in"]


def piece(name: str) -> bpy.types.Object:
    return bpy.data.objects[name]


def mesh_world(obj: bpy.types.Object) -> np.ndarray:
    return np.array([obj.matrix_world @ vertex.co for vertex in obj.data.vertices])


def shift(name: str) -> float:
    """How far the farthest vertex of a piece has come."""
    moved = scenes.shown_positions(piece(name)) - scenes.key_positions(piece(name), "Basis")
    return float(np.linalg.norm(moved, axis=1).max())


def test_a_piece_pulls_the_whole(ui: Ui) -> Steps:
    ui.open_panels("ARAP_PT_attach")
    yield from begin(ui)
    yield from ui.open_tab()
    yield from ui.screenshot("0_piece_in_hand")
    yield from pull(ui, (3.0, -0.24, 1.1), (1.9, -0.24, 2.9))
    assert bpy.context.object == stand_in(), "what is pulled is in hand"
    yield from ui.until(lambda: shift("Hand") > 1.5, "the hand goes along")
    assert shift("Arm") > 1.0
    assert shift("Torso") < 0.7
    assert len(stand_in().arap.pull_pins) == 1
    yield from ui.screenshot("1_pulled")
    yield from pull(ui, (0.0, -0.45, 2.2), (-1.0, -0.45, 2.0))
    yield from ui.until(lambda: shift("Head") > 0.8, "so does the head")
    yield from ui.screenshot("2_head")
    assert not piece("Head").arap.pull_pins
    yield from ui.scroll_tab()
    yield from ui.screenshot("3_panel")
    ui.select(piece("Head"))
    yield from ui.screenshot("4_panel_of_a_piece")
    ui.select(stand_in())
    yield from ui.move_mouse_to_view()
    yield from ui.undo()
    yield from ui.until(lambda: shift("Head") < 0.7, "one step of undo")
    yield from grab(ui, (0.0, -0.45, 2.2), (1.0, -0.45, 2.0))
    yield from ui.key("ESC")
    yield from ui.until_free()
    yield from ui.until(lambda: shift("Head") < 0.7, "Esc")
    yield from ui.undo()
    yield from ui.until(lambda: shift("Hand") < 1e-3, "at rest")


def test_made_taken_back_and_stopped(ui: Ui) -> Steps:
    make = importlib.import_module(f"{MODULE}.attach.stand_in")
    made = add_figure()
    ui.select(*made)
    bpy.ops.ed.undo_push(message="scene")
    step = make.StandInJob.step
    ui.change(make.StandInJob, "step", lambda _self, _limit=0.0: True)
    assert ui.call(bpy.ops.arap.stand_in_make) == {"RUNNING_MODAL"}
    yield from ui.until_bar("Make Stand-in: a stand-in of 4 meshes, 0%")
    yield from ui.key("ESC")
    yield from ui.until_no_bar()
    assert [obj.name for obj in bpy.data.objects] == sorted(PIECES)
    make.StandInJob.step = step
    assert ui.call(bpy.ops.arap.stand_in_make) == {"RUNNING_MODAL"}
    yield from ui.until(lambda: "Stand-in" in bpy.data.objects, "the stand-in is made")
    yield
    yield from ui.undo()
    assert [obj.name for obj in bpy.data.objects] == sorted(PIECES)
    assert piece("Arm").data.shape_keys is None
    yield from ui.redo()
    assert len(stand_in().arap.attachments) == len(PIECES)


def test_a_click_on_a_piece_takes_the_whole(ui: Ui) -> Steps:
    yield from begin(ui)
    other = bpy.data.objects.new("Other", piece("Head").data.copy())
    bpy.context.scene.collection.objects.link(other)
    other.location = (4.5, 0.0, -1.0)
    ui.select(other)
    bpy.ops.ed.undo_push(message="other")
    yield from click(ui, (1.4, -0.25, 1.1))
    assert bpy.context.object == stand_in()
    yield from click(ui, (1.4, -0.25, 1.1))
    assert (len(stand_in().arap.pull_pins), bpy.context.object) == (1, stand_in())


def test_a_hidden_stand_in_is_told(ui: Ui) -> Steps:
    """Also by a click on a piece while something else is in hand."""
    mesh_at = importlib.import_module(f"{MODULE}.pull.other_mesh").mesh_at
    yield from begin(ui)
    told = "'Stand-in' is hidden here: show it first (Alt H, its collection, or leave Local View)"
    stand_in().hide_set(True)
    yield
    yield from point_at(ui, (1.4, -0.25, 1.1))
    assert told in refusal(ui)
    region, said = ui.region(), ""
    try:
        with ui.override():
            mesh_at(bpy.context, (ui.mouse[0] - region.x, ui.mouse[1] - region.y))
    except ValueError as error:
        said = str(error)
    assert said == told


def test_clothes_pull_the_body(ui: Ui) -> Steps:
    """Also where the mouse is beside the host."""
    torso, arm, hand, head = add_figure()
    yield from look_from_front(ui)
    ui.api.attach(torso, [head], "bend")
    ui.select(head)
    assert ui.call(bpy.ops.arap.pull_tool) == {"FINISHED"}
    bpy.ops.ed.undo_push(message="scene")
    yield from pull(ui, (0.0, -0.45, 2.3), (0.4, -0.45, 2.3))
    yield from ui.until(lambda: shift("Torso") > 0.1, "the host is pulled")
    assert head.data.shape_keys.key_blocks.keys() == ["Basis", "ARAP"], "its linked key, no pose of its own"
    assert torso.arap.pull_pins
    assert not head.arap.pull_pins
    ui.select(hand)
    yield from click(ui, (0.5, -0.45, 2.0))
    assert bpy.context.object == torso, "a click on what it carries takes it"
    torso.arap.attachments[0].is_enabled = False
    ui.select(head)
    yield from pull(ui, (0.0, -0.45, 2.0), (0.4, -0.45, 2.0))
    assert head.arap.pull_pins, "switched off, it is pulled itself"
    assert arm.data.shape_keys is None


def test_what_is_behind_a_curve_is_pulled(ui: Ui) -> Steps:
    """Also while the curve is active, and a click on it takes what it goes along with."""
    torso, _, hand, _ = add_figure()
    data = bpy.data.curves.new("Strap", "CURVE")
    data.dimensions, data.bevel_depth = "3D", 0.08
    points = data.splines.new("POLY").points
    points.add(4)
    for point, height in zip(points, (-1.0, -0.5, 0.0, 0.5, 1.0), strict=True):
        point.co = (0.0, -0.7, height, 1.0)
    strap = bpy.data.objects.new("Strap", data)
    bpy.context.scene.collection.objects.link(strap)
    yield from look_from_front(ui)
    ui.api.attach(torso, [strap])
    ui.select(hand)
    assert ui.call(bpy.ops.arap.pull_tool) == {"FINISHED"}
    bpy.ops.ed.undo_push(message="scene")
    yield from click(ui, (0.0, -0.78, 0.2))
    assert bpy.context.object == torso
    ui.select(strap)
    yield from pull(ui, (0.0, -0.78, 0.2), (0.6, -0.78, 0.2))
    yield from ui.until(lambda: shift("Torso") > 0.1, "the host is pulled")
    keys = strap.data.shape_keys.key_blocks
    assert keys.keys() == ["Basis", "ARAP"]
    moved = [a.co.x - b.co.x for a, b in zip(keys["ARAP"].data, keys["Basis"].data, strict=True)]
    assert max(moved) > 0.1
    yield from ui.screenshot("5_curve")
