# SPDX-License-Identifier: GPL-3.0-or-later
"""ARAP Pull, as an artist does it: with the mouse and keys, in a window."""

from collections.abc import Generator
from itertools import pairwise
from typing import NamedTuple
from unittest.mock import Mock

import bpy
import numpy as np
import scenes
from harness import Steps, Ui
from main_loop import move_each_turn

NEAR = 1e-4
Place = tuple[float, float, float]
N = 41  # vertices along a side of the sheet, which is two units wide


def sheet() -> bpy.types.Object:
    return bpy.data.objects["Grid"]


def begin(ui: Ui, n: int = N) -> Steps:
    """A flat sheet seen from above, and the tool in hand."""
    scenes.add_grid(n)
    region = ui.view.spaces.active.region_3d
    region.view_perspective = "ORTHO"
    region.view_rotation = (1.0, 0.0, 0.0, 0.0)
    region.view_location = (0.0, 0.0, 0.0)
    region.view_distance = 4.0
    yield from ui.move_mouse_to_view()
    assert ui.call(bpy.ops.arap.pull_tool) == {"FINISHED"}
    ui.change_pull("radius", 25)
    bpy.ops.ed.undo_push(message="scene")
    yield


def begin_follow(ui: Ui) -> Steps:
    """The same with one edge pinned and the other one on a handle, live."""
    yield from begin(ui)
    scenes.hold(ui.api, sheet(), N)
    sheet().arap.use_follow = True
    yield from ui.until(lambda: ui.follow.run_of(sheet()).is_settled, "Follow has settled")


def refusal(ui: Ui) -> str:
    """What ARAP Pull says that does not begin."""
    try:
        ui.call(bpy.ops.arap.pull)
    except RuntimeError as error:
        return str(error)
    return ""


def point_at(ui: Ui, place: Place) -> Steps:
    """Moves the mouse over a place in the world."""
    yield from ui.move_mouse(*ui.pixel(place))


def press(ui: Ui, place: Place, **modifiers: bool) -> Steps:
    yield from point_at(ui, place)
    ui.event("LEFTMOUSE", "PRESS", **modifiers)
    yield


def drag_to(ui: Ui, place: Place, n_steps: int = 4, **modifiers: bool) -> Steps:
    start, end = np.array(ui.mouse), np.array(ui.pixel(place))
    for i in range(1, n_steps + 1):
        ui.mouse = tuple(int(value) for value in np.round(start + (end - start) * i / n_steps))
        ui.event("MOUSEMOVE", "NOTHING", **modifiers)
        yield


def grab(ui: Ui, start: Place, end: Place, n_steps: int = 4, **modifiers: bool) -> Steps:
    """A drag whose button is still down."""
    yield from press(ui, start, **modifiers)
    yield from drag_to(ui, end, n_steps, **modifiers)


def release(ui: Ui) -> Steps:
    ui.event("LEFTMOUSE", "RELEASE")
    yield from ui.until_free()
    yield


def pull(ui: Ui, start: Place, end: Place) -> Steps:
    """One whole drag."""
    yield from grab(ui, start, end)
    yield from release(ui)


def nearest(rest: np.ndarray, place: Place) -> int:
    return int(np.linalg.norm(rest - place, axis=1).argmin())


def test_pull_undo_redo(ui: Ui) -> Steps:
    """A drag takes the patch with the mouse, live; the rest beyond the reach stays; one undo takes it back."""
    yield from begin(ui)
    rest = scenes.key_positions(sheet())
    middle = nearest(rest, (0.0, 0.0, 0.0))
    yield from point_at(ui, (0.0, 0.0, 0.0))
    yield from ui.screenshot("hover")
    yield from grab(ui, (0.0, 0.0, 0.0), (0.3, 0.1, 0.0))
    assert "Grid" in ui.running
    yield from ui.until(lambda: scenes.shown_positions(sheet())[middle][0] > 0.25, "the mesh follows")
    yield from ui.screenshot("dragging")
    yield from release(ui)
    posed = scenes.shown_positions(sheet())
    np.testing.assert_allclose(posed[middle], (0.3, 0.1, 0.0), atol=0.02)
    far = np.abs(rest[:, :2]).max(axis=1) > 0.9
    np.testing.assert_allclose(posed[far], rest[far], atol=NEAR)
    assert len(sheet().arap.pull_pins) == 1
    yield from ui.screenshot("released")
    yield from ui.undo()
    np.testing.assert_allclose(scenes.shown_positions(sheet()), rest, atol=NEAR)
    assert len(sheet().arap.pull_pins) == 0
    assert sheet().data.shape_keys is None
    yield from ui.redo()
    np.testing.assert_allclose(scenes.shown_positions(sheet()), posed, atol=1e-6)
    assert len(sheet().arap.pull_pins) == 1


def test_a_pull_that_is_over_before_it_is_seen(ui: Ui) -> Steps:
    """A quick drag, whose moves Blender has joined with its end while the press was looked at, is no click."""
    yield from begin(ui)
    middle = nearest(scenes.key_positions(sheet()), (0.0, 0.0, 0.0))
    yield from press(ui, (0.0, 0.0, 0.0))
    ui.mouse = ui.pixel((0.3, 0.1, 0.0))
    ui.event("LEFTMOUSE", "RELEASE")
    yield from ui.until(lambda: scenes.shown_positions(sheet())[middle][0] > 0.25, "the mesh follows")
    yield from release(ui)
    np.testing.assert_allclose(scenes.shown_positions(sheet())[middle], (0.3, 0.1, 0.0), atol=0.02)
    assert len(sheet().arap.pull_pins) == 1
    yield from press(ui, (-0.6, -0.6, 0.0))  # within the threshold it is a click
    yield from release(ui)
    assert len(sheet().arap.pull_pins) == 2
    np.testing.assert_allclose(scenes.shown_positions(sheet())[middle], (0.3, 0.1, 0.0), atol=0.02)


def test_pull_is_drawn(ui: Ui) -> Steps:
    """Every move that the mesh follows draws the view anew: nobody but the drag itself evaluates or redraws here."""
    yield from begin(ui)
    yield from grab(ui, (0.3, 0.0, 0.0), (0.35, 0.0, 0.0))
    yield from ui.until(lambda: bool(ui.running) and ui.running["Grid"].is_settled, "the mesh has bound and follows")
    n_drawn = 0

    def count() -> None:
        nonlocal n_drawn
        n_drawn += 1

    handler = bpy.types.SpaceView3D.draw_handler_add(count, (), "WINDOW", "POST_VIEW")
    for i in range(5):
        before, stats = n_drawn, ui.running["Grid"].stats
        yield from drag_to(ui, (0.4 + 0.05 * i, 0.0, 0.0), 1)
        yield from ui.until(lambda stats=stats: ui.running["Grid"].stats is not stats, "the mesh follows")
        yield from ui.until(lambda before=before: n_drawn > before, "the view is drawn")
    bpy.types.SpaceView3D.draw_handler_remove(handler, "WINDOW")
    yield from release(ui)


def test_pull_solves_each_move_once(ui: Ui) -> Steps:
    """While the mouse is under way its moves are followed: refining would hold up the next one."""
    yield from begin(ui)
    sheet().arap.iterations_per_update = 1  # there is something left to refine
    yield from grab(ui, (0.3, 0.0, 0.0), (0.35, 0.0, 0.0))
    yield from ui.until(lambda: bool(ui.running) and ui.running["Grid"].is_settled, "the mesh has bound and follows")
    run = ui.pull.runs[0]
    update, tick, steps = run.scene.update, run.tick, []

    def noted_update(matrices: object, iterations: int | None, time_limit_s: float | None) -> object:
        steps.append("follow" if iterations is None else "refine")
        return update(matrices, iterations, time_limit_s)

    def noted_tick() -> None:
        tick()
        steps.append("timer")

    run.scene.update, run.tick = noted_update, noted_tick
    x, y = ui.mouse
    yield from move_each_turn(ui, lambda turn: (x + 3 * turn, y), lambda: steps.count("follow") >= 10)
    yield from ui.until(lambda: ui.running["Grid"].is_settled, "the mouse rests: the mesh settles")
    assert "refine" in steps
    assert ("follow", "refine") not in set(pairwise(steps)), "the timer in the turn of a move does nothing"
    yield from release(ui)


def test_pull_esc_restores_that_drag(ui: Ui) -> Steps:
    """Esc, and the right button, give back what the drag changed, to the last bit, and nothing of the drag before."""
    yield from begin(ui)
    rest = scenes.key_positions(sheet())
    yield from grab(ui, (0.4, 0.4, 0.0), (0.6, 0.4, 0.0))
    yield from ui.key("ESC")
    yield from ui.until_free()
    assert sheet().data.shape_keys is None
    ui.event("LEFTMOUSE", "RELEASE")
    yield from pull(ui, (0.0, 0.0, 0.0), (0.2, 0.0, 0.0))
    posed = scenes.key_positions(sheet())
    yield from grab(ui, (0.4, 0.4, 0.0), (0.7, 0.4, 0.0))
    yield from ui.until(lambda: np.abs(scenes.key_positions(sheet()) - posed).max() > 0.1, "the mesh follows")
    yield from ui.key("RIGHTMOUSE")
    yield from ui.until_free()
    ui.event("LEFTMOUSE", "RELEASE")
    yield
    np.testing.assert_array_equal(scenes.key_positions(sheet()), posed)
    assert len(sheet().arap.pull_pins) == 1
    yield from ui.undo()
    np.testing.assert_allclose(scenes.shown_positions(sheet()), rest, atol=NEAR)


def click(ui: Ui, place: Place, **modifiers: bool) -> Steps:
    yield from press(ui, place, **modifiers)
    ui.event("LEFTMOUSE", "RELEASE", **modifiers)
    yield
    yield


def test_pull_pins(ui: Ui) -> Steps:
    """Clicks pin, then all else gives way; Ctrl-click lets go; each is a step of undo; without the tool they go."""
    yield from begin(ui)
    rest = scenes.key_positions(sheet())
    corners = [(-0.9, -0.9, 0.0), (-0.9, 0.9, 0.0)]
    for corner in corners:
        yield from click(ui, corner)
    pins = sheet().arap.pull_pins
    assert [pin.reach for pin in pins] == [0.0, 0.0]
    assert sheet().data.shape_keys is None, "a pin moves nothing"
    yield from pull(ui, (0.9, 0.0, 0.0), (1.2, 0.0, 0.0))
    posed = scenes.shown_positions(sheet())
    for corner in corners:
        i = nearest(rest, corner)
        np.testing.assert_allclose(posed[i], rest[i], atol=0.01)
    moved = posed[nearest(rest, (0.9, 0.9, 0.0))] - rest[nearest(rest, (0.9, 0.9, 0.0))]
    assert np.linalg.norm(moved) > 0.05, "what is not pinned goes along"
    assert len(sheet().arap.pull_pins) == 3
    yield from ui.screenshot("pins")
    yield from click(ui, corners[0], ctrl=True)
    assert len(sheet().arap.pull_pins) == 2
    yield from ui.undo()
    assert len(sheet().arap.pull_pins) == 3
    np.testing.assert_allclose(scenes.shown_positions(sheet()), posed, atol=1e-6)
    ui.call(bpy.ops.wm.tool_set_by_id, "EXEC_DEFAULT", True, name="builtin.select_box")
    yield from ui.until(lambda: not sheet().arap.pull_pins, "the pins go with the tool")
    np.testing.assert_allclose(scenes.shown_positions(sheet()), posed, atol=1e-6)


def test_pull_modifiers_and_axes(ui: Ui) -> Steps:
    """Shift turns about the line of sight, Ctrl goes along the normal, X, Y and Z constrain."""
    yield from begin(ui)
    ui.preferences.pull().radius = 60
    rest = scenes.key_positions(sheet())
    middle = nearest(rest, (0.0, 0.0, 0.0))
    beside = nearest(rest, (0.2, 0.0, 0.0))
    yield from grab(ui, (0.0, 0.0, 0.0), (0.0, 0.3, 0.0), ctrl=True)
    yield from release(ui)
    posed = scenes.shown_positions(sheet())
    np.testing.assert_allclose(posed[middle], (0.0, 0.0, 0.3), atol=0.02)
    yield from ui.screenshot("normal")
    yield from ui.undo()

    yield from press(ui, (0.0, 0.0, 0.0), shift=True)
    x, y = ui.mouse
    for i in range(1, 5):
        ui.mouse = (x - 20 * i, y)
        ui.event("MOUSEMOVE", "NOTHING", shift=True)
        yield
    yield from release(ui)
    turned = scenes.shown_positions(sheet())
    np.testing.assert_allclose(turned[middle], (0.0, 0.0, 0.0), atol=0.02)
    angle = np.radians(40.0)  # half a degree a pixel, 80 pixels to the left: against the clock
    np.testing.assert_allclose(turned[beside], 0.2 * np.array([np.cos(angle), np.sin(angle), 0.0]), atol=0.02)
    yield from ui.undo()

    yield from grab(ui, (0.0, 0.0, 0.0), (0.2, 0.3, 0.0))
    yield from ui.key("X")
    yield from ui.until(lambda: abs(scenes.shown_positions(sheet())[middle][1]) < 0.01, "X constrains")
    yield from ui.key("Y")
    yield from release(ui)
    np.testing.assert_allclose(scenes.shown_positions(sheet())[middle], (0.0, 0.3, 0.0), atol=0.02)


def test_pull_radius(ui: Ui) -> Steps:
    """[ and ] and F change the radius without a step of undo; in a drag the wheel takes hold of more."""
    yield from begin(ui)
    settings = ui.preferences.pull()
    rest = scenes.key_positions(sheet())
    yield from point_at(ui, (0.0, 0.0, 0.0))
    yield from ui.key("RIGHT_BRACKET")
    assert settings.radius == 28
    yield from ui.key("LEFT_BRACKET")
    yield from ui.key("LEFT_BRACKET")
    assert settings.radius == 22
    yield from ui.key("F")
    yield
    yield from ui.move_mouse(ui.mouse[0] + 10, ui.mouse[1])
    yield from ui.move_mouse(ui.mouse[0] + 20, ui.mouse[1])
    yield from ui.screenshot("radius")
    yield from ui.key("LEFTMOUSE")
    yield
    assert settings.radius > 40
    settings.radius = 20
    before = ui.view.spaces.active.region_3d.view_distance
    yield from grab(ui, (0.0, 0.0, 0.0), (0.2, 0.0, 0.0))
    for _ in range(8):
        ui.event("WHEELUPMOUSE")
        yield
    yield from release(ui)
    assert settings.radius > 40
    assert ui.view.spaces.active.region_3d.view_distance == before
    radius = settings.radius * 2.0 / (ui.pixel((1, 0, 0))[0] - ui.pixel((-1, 0, 0))[0])
    posed = scenes.shown_positions(sheet())
    patch = np.linalg.norm(rest, axis=1) < 0.9 * radius
    np.testing.assert_allclose(posed[patch], rest[patch] + (0.2, 0.0, 0.0), atol=0.02)
    yield from ui.undo()
    np.testing.assert_allclose(scenes.shown_positions(sheet()), rest, atol=NEAR)


def test_pull_becomes_handles(ui: Ui) -> Steps:
    """Ctrl H makes a handle of what was pulled and pins of what was held; the mesh stays, and Pose goes on from it."""
    yield from begin(ui)
    rest = scenes.key_positions(sheet())
    middle = nearest(rest, (0.0, 0.0, 0.0))
    yield from pull(ui, (0.0, 0.0, 0.0), (0.0, 0.25, 0.0))
    posed = scenes.shown_positions(sheet())
    yield from ui.key("H", ctrl=True)
    yield
    settings = sheet().arap
    assert len(settings.pull_pins) == 0
    assert [handle.name for handle in settings.handles] == ["Middle"]
    assert [pin.name for pin in settings.pins] == ["Everything Else"]
    yield from ui.until(lambda: ui.follow.run_of(sheet()).is_settled, "the mesh follows")
    np.testing.assert_allclose(scenes.shown_positions(sheet()), posed, atol=1e-4)
    yield from ui.screenshot("handles")
    assert ui.call(bpy.ops.arap.pose) == {"RUNNING_MODAL"}
    yield from ui.until(lambda: "Grid" in ui.running and ui.running["Grid"].is_settled, "posing has settled")
    yield from ui.key("RET")
    np.testing.assert_allclose(scenes.shown_positions(sheet())[middle], posed[middle], atol=0.02)
    np.testing.assert_allclose(scenes.shown_positions(sheet()), posed, atol=0.06)


def test_pull_mirrored(ui: Ui) -> Steps:
    """With Mirror X the other side does the mirror image, and what lies on the plane stays on it."""
    yield from begin(ui)
    sheet().data.use_mirror_x = True
    rest = scenes.key_positions(sheet())
    yield from pull(ui, (0.5, 0.0, 0.0), (0.5, 0.25, 0.0))
    yield from pull(ui, (0.0, -0.5, 0.0), (0.2, -0.3, 0.0))
    posed = scenes.shown_positions(sheet())
    assert len(sheet().arap.pull_pins) == 3
    image = posed * (-1.0, 1.0, 1.0)
    partner = [nearest(rest, place * (-1.0, 1.0, 1.0)) for place in rest]
    np.testing.assert_allclose(posed[partner], image, atol=0.01)
    assert posed[nearest(rest, (-0.5, 0.0, 0.0))][1] > 0.2
    np.testing.assert_allclose(posed[nearest(rest, (0.0, -0.5, 0.0))], (0.0, -0.3, 0.0), atol=0.03)
    yield from ui.screenshot("mirrored")


def test_pull_interrupted_settling(ui: Ui) -> Steps:
    """A press while the mesh still settles ends that, and means what it means: undo, or the next drag."""
    yield from begin(ui)
    rest = scenes.key_positions(sheet())
    for is_undo in (False, True):
        with ui.held_settling():
            yield from grab(ui, (0.3, 0.0, 0.0), (0.3, 0.2, 0.0))
            yield from ui.until(lambda: np.abs(scenes.shown_positions(sheet()) - rest).max() > 0.15, "the mesh follows")
            ui.event("LEFTMOUSE", "RELEASE")
            yield
            yield from ui.until_held()
            if is_undo:
                yield from ui.undo()
                yield from ui.until_free()
            else:
                yield from press(ui, (-0.3, 0.0, 0.0))
        if is_undo:
            np.testing.assert_allclose(scenes.shown_positions(sheet()), rest, atol=NEAR)
        else:
            yield from drag_to(ui, (-0.3, 0.2, 0.0))
            yield from release(ui)
            assert len(sheet().arap.pull_pins) == 2
            for _ in range(2):
                yield from ui.undo()
            np.testing.assert_allclose(scenes.shown_positions(sheet()), rest, atol=NEAR)


def test_pull_esc_while_it_binds(ui: Ui) -> Steps:
    """The view shows how far it is, and Esc takes the drag back."""
    yield from begin(ui, 21)
    rest = scenes.key_positions(sheet())
    with ui.held_stage():
        yield from grab(ui, (0.3, 0.0, 0.0), (0.3, 0.2, 0.0), 2)
        yield from ui.until_bar("Preparing Grid, ")
        yield from ui.screenshot("bar")
        yield from ui.key("ESC")
        yield from ui.until_free()
    ui.event("LEFTMOUSE", "RELEASE")
    yield from ui.until_no_bar()
    np.testing.assert_array_equal(scenes.shown_positions(sheet()), rest)


def test_pull_keys_are_told_before_a_drag(ui: Ui) -> Steps:
    """The status bar has the tool's keys as long as nothing else is under way."""
    yield from begin(ui, 21)
    assert tells_keys(ui)
    yield from ui.screenshot("hover")
    yield from press(ui, (0.3, 0.0, 0.0))
    assert tells_keys(ui)
    yield from drag_to(ui, (0.3, 0.2, 0.0))
    assert not tells_keys(ui), "the drag has a text of its own"
    yield from release(ui)
    assert tells_keys(ui)
    ui.call(bpy.ops.wm.tool_set_by_id, "EXEC_DEFAULT", name="builtin.select_box")
    assert not tells_keys(ui)


def tells_keys(ui: Ui) -> bool:
    """Whether the status bar has the tool's keys."""
    header = Mock()
    with ui.override():
        ui.pull_tool.draw_keys(header, bpy.context)
    return header.layout.label.called


def test_pull_undone_while_it_binds(ui: Ui) -> Steps:
    """Let go of while the mesh is still being prepared, a drag is what undo takes back; a redo ends it too."""
    yield from begin(ui, 21)
    for number in (1, 2):
        bpy.context.scene["step"] = number
        bpy.ops.ed.undo_push(message="step")
    rest = scenes.key_positions(sheet())

    def pull_and_press_z(**modifiers: bool) -> Steps:
        with ui.held_stage():
            yield from grab(ui, (0.3, 0.0, 0.0), (0.3, 0.2, 0.0), 2)
            yield from ui.until_held()
            ui.event("LEFTMOUSE", "RELEASE")
            yield
            yield from ui.key("Z", ctrl=True, **modifiers)
            yield from ui.until_free()
        yield
        np.testing.assert_array_equal(scenes.shown_positions(sheet()), rest)
        assert sheet().data.shape_keys is None
        assert not sheet().arap.pull_pins

    yield from pull_and_press_z()
    assert bpy.context.scene["step"] == 2
    yield from ui.undo()
    assert bpy.context.scene["step"] == 1
    yield from pull_and_press_z(shift=True)
    assert bpy.context.scene["step"] == 2


def test_a_pull_ends_following(ui: Ui) -> Steps:
    """The mesh keeps the pull: Follow is off. Esc and undo leave it on. Made into handles, a pull stays with Follow."""
    yield from begin_follow(ui)
    sheet().arap.handles[0].target.location.y += 0.3
    yield from ui.until(lambda: ui.follow.run_of(sheet()).is_settled, "the mesh follows")
    bpy.ops.ed.undo_push(message="moved")
    yield
    start = scenes.shown_positions(sheet())

    yield from grab(ui, (0.0, 0.2, 0.0), (0.0, 0.5, 0.0))
    yield from ui.until(lambda: np.abs(scenes.shown_positions(sheet()) - start).max() > 0.1, "it is pulled")
    yield from ui.key("ESC")
    yield from release(ui)
    assert sheet().arap.use_follow
    yield from ui.until(lambda: ui.follow.run_of(sheet()).is_settled, "it follows again")
    np.testing.assert_allclose(scenes.shown_positions(sheet()), start, atol=1e-3)

    yield from pull(ui, (0.0, 0.2, 0.0), (0.0, 0.5, 0.0))
    pulled = scenes.shown_positions(sheet())
    assert np.abs(pulled - start).max() > 0.1
    assert (sheet().arap.use_follow, len(sheet().arap.pull_pins)) == (False, 1)
    yield from ui.screenshot("off")
    yield from ui.undo()
    assert (sheet().arap.use_follow, len(sheet().arap.pull_pins)) == (True, 0)
    yield from ui.until(lambda: ui.follow.run_of(sheet()).is_settled, "it follows again")
    np.testing.assert_allclose(scenes.shown_positions(sheet()), start, atol=1e-3)

    yield from ui.redo()
    assert not sheet().arap.use_follow
    np.testing.assert_allclose(scenes.shown_positions(sheet()), pulled, atol=1e-6)
    assert ui.call(bpy.ops.arap.pull_make_real) == {"FINISHED"}
    sheet().arap.use_follow = True
    yield from ui.until(lambda: ui.follow.run_of(sheet()).is_settled, "it follows")
    np.testing.assert_allclose(scenes.shown_positions(sheet()), pulled, atol=5e-3)


def test_pull_ends_on_a_fault(ui: Ui) -> Steps:
    """Whatever fails within a drag, it ends, and the mesh goes back."""
    yield from begin(ui)
    rest = scenes.key_positions(sheet())
    yield from grab(ui, (0.0, 0.0, 0.0), (0.3, 0.1, 0.0))
    yield from ui.until(lambda: np.abs(scenes.shown_positions(sheet()) - rest).max() > 0.1, "it is pulled")

    def fail(_drag: object, _mouse: object) -> None:
        raise RuntimeError("a fault")

    ui.change(ui.pull.Drag, "to", fail)
    yield from drag_to(ui, (0.4, 0.1, 0.0), 1)
    yield from ui.until_free()
    np.testing.assert_allclose(scenes.shown_positions(sheet()), rest, atol=NEAR)
    yield from release(ui)


def test_pull_and_follow(ui: Ui) -> Steps:
    """A mesh that follows goes on while another one is pulled."""
    yield from begin_follow(ui)
    rest = scenes.key_positions(sheet())
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=20, y_subdivisions=20)
    pulled = bpy.context.object
    pulled.name = "Pulled"
    pulled.location.z = 1.0
    yield from point_at(ui, (1.3, -1.3, 0.0))  # away from the menu that has shown the error, which closes it
    yield from ui.key("ESC")  # in Blender 5 this does
    flat = scenes.key_positions(pulled)
    yield
    yield from grab(ui, (0.0, 0.0, 1.0), (0.2, 0.0, 1.0))
    assert "Pulled" in ui.running
    sheet().arap.handles[0].target.location.y += 0.5
    yield from ui.until(lambda: np.abs(scenes.shown_positions(sheet()) - rest).max() > 0.4, "Follow follows")
    yield from release(ui)
    assert np.abs(scenes.shown_positions(bpy.data.objects["Pulled"]) - flat).max() > 0.15
    assert sheet().arap.follow_error == ""

    # Switched on within a pull, Follow takes the mesh over once that is over.
    pulled = bpy.data.objects["Pulled"]
    ui.api.add_pin(pulled, [0], name="Corner")
    ui.api.add_handle(pulled, [399], name="Far")
    yield from grab(ui, (0.0, 0.5, 1.0), (0.2, 0.5, 1.0))
    assert "Pulled" in ui.running
    bpy.data.objects["Pulled"].arap.use_follow = True
    live = ui.follow.run_of(bpy.data.objects["Pulled"])
    yield from ui.until(lambda: live.pause == "Paused while it is pulled", "Follow waits")
    yield from release(ui)
    assert len(bpy.data.objects["Pulled"].arap.pull_pins) == 2
    yield from ui.until(lambda: not ui.follow.run_of(bpy.data.objects["Pulled"]).pause, "Follow goes on")
    assert bpy.data.objects["Pulled"].arap.follow_error == ""


def test_pull_undone_leaves_follow_off(ui: Ui) -> Steps:
    """What Follow has given up before a pull stays given up when the pull is undone; the undo before it tries again."""
    yield from begin_follow(ui)
    bpy.ops.ed.undo_push(message="live")
    sheet().data.shape_keys.key_blocks["ARAP"].mute = True
    sheet().arap.handles[0].target.location.z += 0.5
    yield from ui.until(lambda: not sheet().arap.use_follow, "Follow is off")
    sheet().data.shape_keys.key_blocks["ARAP"].mute = False
    yield
    before = scenes.shown_positions(sheet())
    yield from pull(ui, (0.3, 0.0, 0.0), (0.3, 0.2, 0.0))
    assert np.abs(scenes.shown_positions(sheet()) - before).max() > 0.1
    yield from ui.undo()
    for _ in range(3):
        yield
    assert (sheet().arap.use_follow, sheet().arap.follow_error, ui.follow.run_of(sheet())) == (False, "", None)
    np.testing.assert_allclose(scenes.shown_positions(sheet()), before, atol=NEAR)
    yield from ui.undo()
    yield from ui.until(lambda: sheet().arap.use_follow, "Follow is on again")


def test_pull_other_file_within(ui: Ui) -> Steps:
    """Loading a file, and File > New, end the drag, quietly; temporary pins that were saved go if the tool is off."""
    yield from begin(ui)
    yield from grab(ui, (0.3, 0.0, 0.0), (0.5, 0.3, 0.0))
    ui.call(bpy.ops.wm.read_homefile, "EXEC_DEFAULT", use_factory_startup=True)
    yield from ui.until_free()
    ui.event("LEFTMOUSE", "RELEASE")
    yield
    yield from begin(ui)
    yield from click(ui, (-0.9, -0.9, 0.0))
    assert len(sheet().arap.pull_pins) == 1
    path = f"{bpy.app.tempdir}sheet.blend"
    bpy.ops.wm.save_as_mainfile(filepath=path)
    rest = scenes.key_positions(sheet())
    yield from grab(ui, (0.3, 0.0, 0.0), (0.3, 0.2, 0.0))
    yield from ui.until(lambda: np.abs(scenes.shown_positions(sheet()) - rest).max() > 0.1, "the mesh follows")
    bpy.ops.wm.open_mainfile(filepath=path)
    yield from release(ui)
    assert sheet().data.shape_keys is None
    ui.call(bpy.ops.wm.tool_set_by_id, "EXEC_DEFAULT", True, name="builtin.select_box")
    yield from ui.until(lambda: not sheet().arap.pull_pins, "the pins go with the tool")


def test_pull_beside_the_mesh(ui: Ui) -> Steps:
    """A drag turns the view, a click does nothing: nothing in the scene moves, and what is selected stays so."""
    yield from begin(ui)
    sheet().scale = (0.4, 0.4, 0.4)
    bpy.ops.mesh.primitive_cube_add(size=0.6, location=(1.2, 0.0, 0.0))
    cube = bpy.context.object
    ui.select(sheet())
    bpy.ops.ed.undo_push(message="cube")
    region = ui.view.spaces.active.region_3d

    def state() -> tuple[object, ...]:
        objects = [(obj.name, obj.select_get(), [*map(tuple, obj.matrix_world)]) for obj in bpy.data.objects]
        return objects, bpy.context.object, len(sheet().arap.pull_pins), sheet().data.shape_keys

    def turns_only(start: Place, **modifiers: bool) -> Steps:
        before, rotation = state(), region.view_rotation.copy()
        yield from grab(ui, start, (start[0] - 0.2, start[1] + 0.1, 0.0), **modifiers)
        yield from release(ui)
        assert state() == before, f"a drag from {start} with {modifiers} changed the scene"
        assert region.view_rotation.rotation_difference(rotation).angle > 0.02
        turned = region.view_rotation.copy()
        yield from ui.move_mouse_to_view()
        assert region.view_rotation == turned, "the end of the drag ends the turn"
        region.view_rotation = rotation
        yield

    perspective = region.view_perspective
    for start in ((0.0, 0.8, 0.0), (1.2, 0.0, 0.0)):  # on nothing, on another mesh
        for modifiers in ({}, {"shift": True}, {"ctrl": True}):
            before = state()
            if start == (0.0, 0.8, 0.0) or "ctrl" in modifiers:  # else a click takes the other mesh in hand
                yield from click(ui, start, **modifiers)
                assert state() == before
            assert region.view_perspective == perspective, "a click leaves an axis view as it is"
            yield from turns_only(start, **modifiers)
    sheet().select_set(False)
    bpy.context.view_layer.objects.active = None
    yield from turns_only((1.2, 0.0, 0.0))
    yield from click(ui, (1.2, 0.0, 0.0))
    assert bpy.context.object == cube, "with no mesh in hand a click takes one"


def test_pull_takes_another_mesh(ui: Ui) -> Steps:
    """A click on a mesh in front takes it in hand, also if the former one cannot be pulled. A drag pulls the former."""
    yield from begin(ui)
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.3, location=(0.3, 0.0, 0.5))
    ball = bpy.context.object
    ui.select(sheet())
    bpy.ops.ed.undo_push(message="ball")
    place = (0.3, 0.0, 0.0)

    def in_hand() -> tuple[object, list[object]]:
        return bpy.context.object, [obj for obj in bpy.data.objects if obj.select_get()]

    yield from pull(ui, place, (0.3, 0.2, 0.0))
    assert in_hand() == (sheet(), [sheet()])
    assert np.abs(scenes.shown_positions(sheet())[:, 2]).max() < NEAR, "the mesh in hand goes along the view"
    assert (len(sheet().arap.pull_pins), len(ball.arap.pull_pins)) == (1, 0)
    yield from click(ui, place)
    assert in_hand() == (ball, [ball])
    yield from ui.screenshot("taken")
    yield from click(ui, place)
    assert (len(sheet().arap.pull_pins), len(ball.arap.pull_pins)) == (1, 1), "the next click pins"
    yield from click(ui, (-0.5, 0.0, 0.0))
    assert in_hand() == (sheet(), [sheet()])
    yield from ui.undo()
    assert bpy.context.object.name == "Sphere", "a click is one step of undo"
    yield from ui.redo()
    ball = bpy.data.objects["Sphere"]
    for name, value in (("hide_select", True), ("display_type", "WIRE")):
        before = getattr(ball, name)
        setattr(ball, name, value)
        yield from click(ui, place)
        assert bpy.context.object == sheet(), f"{name} keeps it out of hand"
        setattr(ball, name, before)
    sheet().data.shape_keys.use_relative = False
    yield from click(ui, place)
    assert bpy.context.object == ball


def test_pull_bad_cases(ui: Ui) -> Steps:
    """Hidden, out of local view, made by a modifier, beside the mesh: nothing changes, and nothing breaks."""
    yield from begin(ui)
    obj = sheet()
    rest = scenes.key_positions(obj)
    other = bpy.data.objects.new("Other", bpy.data.meshes.new("Other"))
    bpy.context.scene.collection.objects.link(other)

    def refused(sentence: str) -> Steps:
        yield from point_at(ui, (0.3, 0.0, 0.0))
        assert sentence in refusal(ui)
        yield from pull(ui, (0.3, 0.0, 0.0), (0.3, 0.2, 0.0))
        yield from ui.until_free()
        np.testing.assert_array_equal(scenes.key_positions(sheet()), rest)
        assert not sheet().arap.pull_pins

    obj.hide_set(True)
    hidden = "'Grid' is hidden here: show it first (Alt H, its collection, or leave Local View)"
    yield from refused(hidden)
    obj.hide_set(False)

    ui.select(other)
    ui.call(bpy.ops.view3d.localview)
    yield
    bpy.context.view_layer.objects.active = obj
    yield
    yield from refused(hidden)
    ui.call(bpy.ops.view3d.localview)
    ui.select(obj)
    yield

    obj.modifiers.new("Thick", "SOLIDIFY").thickness = 0.2
    obj.modifiers.new("Remesh", "REMESH").voxel_size = 0.05
    yield
    yield from ui.screenshot("opaque")
    yield from refused("Modifier 'Remesh' of 'Grid' makes other vertices")
    obj.modifiers.clear()

    yield from click(ui, (1.3, 0.0, 0.0))  # closes the message of Blender
    yield from click(ui, (0.5, 0.5, 0.0))
    assert len(obj.arap.pull_pins) == 1
    yield from ui.key("TAB")
    yield from ui.until(lambda: not sheet().arap.pull_pins, "editing the mesh ends its temporary pins")
    yield from ui.key("TAB")
    yield from pull(ui, (0.3, 0.0, 0.0), (0.3, 0.2, 0.0))
    assert np.abs(scenes.shown_positions(sheet()) - rest).max() > 0.1


class Ear(NamedTuple):
    """The mesh, its rest shape, the vertex at the tip of an ear, and a place in the ear that can be grabbed."""

    mesh: bpy.types.Object
    rest: np.ndarray
    tip: int
    inside: Place


def add_monkey(ui: Ui) -> Generator[None, None, Ear]:
    """A head with two ears, seen from the front, and the tool in hand."""
    yield from begin(ui)
    bpy.data.objects.remove(sheet())
    bpy.ops.mesh.primitive_monkey_add(size=2.0)
    ui.view.spaces.active.region_3d.view_rotation = (0.7071068, 0.7071068, 0.0, 0.0)
    bpy.ops.ed.undo_push(message="monkey")
    yield
    assert ui.call(bpy.ops.arap.pull_tool) == {"FINISHED"}
    monkey = bpy.context.object
    rest = scenes.key_positions(monkey)
    tip = int(rest[:, 0].argmax())
    return Ear(monkey, rest, tip, (rest[tip, 0] - 0.05, 0.0, rest[tip, 2]))


def test_pull_stops_where_the_limb_is_straight(ui: Ui) -> Steps:
    """Beyond its reach the ear stays behind the mouse, which is shown; with Alt it stretches."""
    monkey, rest, tip, inside = yield from add_monkey(ui)
    far = (inside[0] + 1.0, 0.0, inside[2] + 0.2)

    def shift() -> float:
        return float(np.linalg.norm(scenes.shown_positions(monkey)[tip] - rest[tip]))

    yield from grab(ui, inside, far)
    yield from ui.until(lambda: ui.running["Suzanne"].is_settled, "the mesh follows")
    assert ui.pull.runs[0].drag.is_beyond
    assert shift() < 0.5
    yield from ui.screenshot("beyond")
    yield from drag_to(ui, far, 2, alt=True)
    yield from ui.until(lambda: shift() > 0.9, "the ear stretches")
    assert not ui.pull.runs[0].drag.is_beyond
    yield from release(ui)


def test_pull_takes_the_limb(ui: Ui) -> Steps:
    """A first drag of a figure, without pins: the limb comes with the mouse from its root and keeps its length."""
    monkey, rest, tip, inside = yield from add_monkey(ui)
    ear = (rest[:, 0] > 0.85) & (rest[:, 2] > -0.2)
    yield from pull(ui, inside, (inside[0] - 0.1, 0.0, inside[2] + 0.3))
    yield from ui.screenshot("ear")
    posed = scenes.shown_positions(monkey)
    moved = np.linalg.norm(posed - rest, axis=1)
    assert moved[tip] > 0.2
    assert moved[rest[:, 0] < 0.6].max() < 0.01 * np.linalg.norm(np.ptp(rest, axis=0))
    ends = np.array([edge.vertices[:] for edge in monkey.data.edges if ear[list(edge.vertices)].all()])
    lengths = [np.linalg.norm(shape[ends[:, 0]] - shape[ends[:, 1]], axis=1).sum() for shape in (rest, posed)]
    assert abs(lengths[1] / lengths[0] - 1.0) < 0.05, lengths


def test_pull_turns_the_limb_about_its_joint(ui: Ui) -> Steps:
    """With Shift the ear goes the way of the mouse around its joint, which is drawn, and the head stays."""
    monkey, rest, tip, inside = yield from add_monkey(ui)
    yield from grab(ui, inside, (inside[0] - 0.1, 0.0, inside[2] + 0.3), shift=True)
    yield from ui.until(lambda: ui.running["Suzanne"].is_settled, "the mesh follows")
    yield from ui.screenshot("turning")
    yield from release(ui)
    moved = scenes.shown_positions(monkey) - rest
    assert moved[tip, 2] > 0.2
    assert np.linalg.norm(moved[rest[:, 0] < 0.6], axis=1).max() < 0.01 * np.linalg.norm(np.ptp(rest, axis=0))
