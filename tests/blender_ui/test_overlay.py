# SPDX-License-Identifier: GPL-3.0-or-later
"""The overlay: pins, handles and their way from rest, strain with its legend. Pictures are kept to be looked at."""

import bpy
import numpy as np
import scenes
from harness import Steps, Ui


def drawn(ui: Ui):
    """What was drawn last, by the name of its object."""
    return {ui.known.find(uid).name: batches for uid, batches in ui.overlay._drawn.items()}


def show_all(obj: bpy.types.Object) -> None:
    overlay = obj.arap.overlay
    overlay.show_pins = overlay.show_handles = overlay.show_strain = True


def bent_bar(ui: Ui) -> bpy.types.Object:
    bar = scenes.add_bar_with_handle(ui.api)
    top = bpy.data.objects["Top"]
    top.location = (1.2, 0.0, 3.6)
    top.rotation_euler.y = 0.9
    bpy.context.view_layer.update()
    ui.api.solve(bar)
    return bar


def redraw(ui: Ui) -> Steps:
    ui.region().tag_redraw()
    yield
    yield


def test_overlay_shows_what_it_should(ui: Ui) -> Steps:
    bar = bent_bar(ui)
    bar.arap.overlay.show_pins = bar.arap.overlay.show_handles = False
    yield from redraw(ui)
    assert drawn(ui) == {}, "nothing is on: nothing is read"
    for name in ("show_pins", "show_handles"):
        bar.arap.overlay.property_unset(name)
    yield from redraw(ui)
    found = drawn(ui)["Bar"]
    assert (found.heat, found.pins is None, found.lines is None) == (None, False, False), "seen without being asked for"
    ui.select(bar)
    yield from ui.open_tab()
    show_all(bar)
    yield from redraw(ui)
    found = drawn(ui)["Bar"]
    assert found.heat is not None
    assert found.pins is not None
    np.testing.assert_allclose(found.ends[1], (1.2, 0.0, 3.6), atol=1e-5)
    np.testing.assert_allclose(found.ends[0][:2], (0.0, 0.0), atol=1e-5)
    np.testing.assert_array_equal(found.pinned, scenes.bottom())
    yield from ui.screenshot("all")
    bar.arap.overlay.show_strain = False
    yield from redraw(ui)
    yield from ui.screenshot("pins_and_handles")
    assert drawn(ui)["Bar"].heat is None
    ui.view.spaces.active.overlay.show_overlays = False
    yield from redraw(ui)
    yield from ui.screenshot("overlays_off")
    ui.view.spaces.active.overlay.show_overlays = True
    bar.hide_set(True)
    yield from redraw(ui)
    bar.hide_set(False)


def test_the_cubes_of_a_solid_are_drawn_as_they_are_bent(ui: Ui) -> Steps:
    bar = bent_bar(ui)
    bar.arap.model = "solid"
    bar.arap.overlay.show_cubes = True
    ui.api.solve(bar)
    yield from redraw(ui)
    assert drawn(ui)["Bar"].cubes is not None
    yield from ui.screenshot("cubes")
    bar.arap.model = "surface"
    ui.api.solve(bar)
    yield from redraw(ui)
    assert drawn(ui)["Bar"].cubes is None


def test_overlay_builds_only_what_changed(ui: Ui) -> Steps:
    bar = bent_bar(ui)
    show_all(bar)
    ui.select(bar)
    yield from redraw(ui)
    first = drawn(ui)["Bar"]
    heat, pins, lines = first.heat, first.pins, first.lines
    for _ in range(3):
        yield from redraw(ui)
    assert (first.heat, first.pins, first.lines) == (heat, pins, lines)
    bpy.data.objects["Top"].location.x = 0.5
    yield from redraw(ui)
    assert first.heat is heat, "a handle alone moves its line"
    assert first.lines is not lines
    ui.api.solve(bar)
    yield from redraw(ui)
    assert drawn(ui)["Bar"] is first, "a pose leaves faces and edges as they are"
    assert first.heat is not heat
    bar.arap.pins[0].is_enabled = False
    bar.vertex_groups["Bottom"].remove(scenes.bottom())
    bar.vertex_groups["Bottom"].add([0], 1.0, "REPLACE")
    bar.arap.pins[0].is_enabled = True
    yield from redraw(ui)
    np.testing.assert_array_equal(drawn(ui)["Bar"].pinned, [0])


def test_overlay_survives_what_happens_to_a_mesh(ui: Ui) -> Steps:
    bar = bent_bar(ui)
    show_all(bar)
    ui.select(bar)
    bpy.ops.ed.undo_push(message="bent")
    yield from redraw(ui)
    modifier = bar.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = 2
    yield from redraw(ui)
    yield from ui.screenshot("subdivided")
    bar.modifiers.remove(modifier)
    yield from ui.move_mouse_to_view()
    yield from ui.key("TAB")
    yield from redraw(ui)
    ui.call(bpy.ops.mesh.select_all, "EXEC_DEFAULT", True, action="SELECT")
    ui.call(bpy.ops.mesh.subdivide, "EXEC_DEFAULT", True)
    yield from ui.key("TAB")
    yield from redraw(ui)
    assert len(drawn(ui)["Bar"].surface.rest) == len(bpy.data.objects["Bar"].data.vertices) > 4 * scenes.N_RINGS
    for _ in range(3):
        yield from ui.undo()
        yield from redraw(ui)
    bpy.data.objects["Bar"].scale = (0.0, 1.0, 1.0)
    yield from redraw(ui)
    bpy.data.objects.remove(bpy.data.objects["Bar"])
    yield from redraw(ui)
