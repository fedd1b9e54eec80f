# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights painted with a real brush: the mesh follows when the stroke ends, in Follow and within a posing act."""

import bpy
import numpy as np
import scenes
import test_pose
from harness import Steps, Ui
from test_follow import SAME, bar, settle

STROKE = 120  # pixels, across the bar
MIDDLE = scenes.LENGTH / 2


def weights_of(group: str) -> np.ndarray:
    index = bar().vertex_groups[group].index
    return np.array([sum(g.weight for g in v.groups if g.group == index) for v in bar().data.vertices])


def show_front(ui: Ui) -> None:
    """The bar from the front, its handle moved half a unit to the right; a pin Waist has no weights yet."""
    scenes.add_bar_with_handle(ui.api)
    bar().vertex_groups.new(name="Waist")
    ui.api.add_pin_group(bar(), "Waist")
    bar().arap.accuracy, bar().arap.max_iterations = 1e-6, 2000
    with ui.override():
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_all()
    bpy.data.objects["Top"].location.x += 0.5


def paint(ui: Ui, group: str, obj: bpy.types.Object | None = None) -> Steps:
    """The button Paint, and a brush of weight 1 over whatever is within it; of the bar, or of another object."""
    obj = obj or bar()
    if obj.mode != "WEIGHT_PAINT" or obj.vertex_groups.active.name != group:  # else it would leave
        assert ui.call(bpy.ops.arap.group_paint, "EXEC_DEFAULT", True, vertex_group=group) == {"FINISHED"}
    assert (obj.mode, obj.vertex_groups.active.name) == ("WEIGHT_PAINT", group)
    settings = bpy.context.scene.tool_settings
    yield from take_brush(ui)
    brush = settings.weight_paint.brush
    brush.use_frontface = False
    unified = getattr(settings.weight_paint, "unified_paint_settings", None) or settings.unified_paint_settings
    for owner in (unified, brush):
        owner.size, owner.weight, owner.strength = 40, 1.0, 1.0
    yield


def take_brush(ui: Ui) -> Steps:
    """A brush in hand in Weight Paint: from 4.3 on brushes are assets, which Debian's packages lack."""
    paint = bpy.context.scene.tool_settings.weight_paint
    if paint.brush is None:
        bpy.data.brushes.new("Painter", mode="WEIGHT_PAINT").asset_mark()
        asset = {"asset_library_type": "LOCAL", "relative_asset_identifier": "Brush/Painter"}
        ui.call(bpy.ops.brush.asset_activate, "EXEC_DEFAULT", True, **asset)
        yield from ui.until(lambda: paint.brush is not None, "there is a brush")


def stroke(ui: Ui, height: float = MIDDLE, *, rests: bool = False, then: str = "") -> Steps:
    """From left to right over the bar where it is shown, the left button down.

    ``rests``: before the button is up. ``then`` is a key that is pressed in the same moment.
    """
    x, y = ui.pixel((0.0, 0.0, height))
    yield from ui.move_mouse(x - STROKE // 2, y)
    ui.event("LEFTMOUSE", "PRESS")
    yield
    for share in range(1, 11):
        yield from ui.move_mouse(x - STROKE // 2 + share * STROKE // 10, y)
    if rests:
        yield from rest(ui)
    ui.event("LEFTMOUSE", "RELEASE")
    if then:
        ui.press(then)
    yield


def rest(ui: Ui) -> Steps:
    """The mouse rests within a stroke: the mesh does not follow yet."""
    before = scenes.key_positions(bar())
    for _ in range(20):
        yield
    np.testing.assert_array_equal(scenes.key_positions(bar()), before)


def session(ui: Ui) -> object:
    return ui.session_of("Bar").session


def assert_as_solved(ui: Ui) -> None:
    """The pose is the one that Solve makes of the weights as they are."""
    shown = scenes.key_positions(bar())
    ui.api.solve(bar())
    np.testing.assert_allclose(shown, scenes.key_positions(bar()), atol=SAME)


def test_follow_follows_a_painted_pin(ui: Ui) -> Steps:
    """A pin that is painted onto the live mesh holds when the stroke has ended; undo of the stroke lets it go."""
    show_front(ui)
    bar().arap.use_follow = True
    yield from settle(ui)
    free = scenes.key_positions(bar())
    yield from paint(ui, "Waist")
    yield from settle(ui)
    bound, n_before = session(ui), session(ui).n_factorizations
    bpy.ops.ed.undo_push(message="before the stroke")
    yield from stroke(ui, rests=True)
    yield from settle(ui)
    yield from ui.screenshot("painted")
    assert weights_of("Waist").max() > 0.5
    assert session(ui) is bound, "only constraints have changed: there is no new bind"
    assert session(ui).n_factorizations > n_before
    assert np.abs(scenes.key_positions(bar()) - free).max() > 0.05
    yield from ui.undo()
    yield from settle(ui)
    assert weights_of("Waist").max() == 0.0
    assert bar().mode == "WEIGHT_PAINT"
    np.testing.assert_allclose(scenes.key_positions(bar()), free, atol=SAME)
    yield from ui.redo()
    yield from settle(ui)
    assert weights_of("Waist").max() > 0.5
    bar().arap.use_follow = False
    assert_as_solved(ui)


def test_follow_waits_for_weights_and_follows_painted_stiffness(ui: Ui) -> Steps:
    """A handle whose weights are not painted yet pauses Follow; stiffness is bound anew, and undone with the stroke."""
    show_front(ui)
    bar().arap.use_follow = True
    yield from settle(ui)
    yield from paint(ui, "Top")
    bar().vertex_groups["Top"].remove(range(len(bar().data.vertices)))
    bar().data.update_tag()
    lack = (
        "Paused: Handle 'Top' of 'Bar': vertex group 'Top' has no weights; assign vertices to it or remove the handle"
    )
    yield from ui.until(lambda: ui.follow.run_of(bar()).pause == lack, "Follow waits for weights")
    yield from stroke(ui, scenes.LENGTH - 0.2)
    yield from settle(ui)
    assert bar().arap.use_follow
    ui.call(bpy.ops.arap.stiffness_add, "INVOKE_DEFAULT", True)
    assert [entry.name for entry in bar().arap.stiffness] == ["Stiff"]
    yield from settle(ui)
    yield from paint(ui, "Stiff")
    before, bound = scenes.key_positions(bar()), session(ui)
    yield from stroke(ui)
    yield from settle(ui)
    assert session(ui) is not bound
    assert np.abs(scenes.key_positions(bar()) - before).max() > 0.01
    ui.call(bpy.ops.arap.group_paint, "EXEC_DEFAULT", True, vertex_group="Stiff")
    assert bar().mode == "OBJECT"
    yield from settle(ui)
    bar().arap.use_follow = False
    assert_as_solved(ui)


def test_a_posing_act_follows_a_painted_pin(ui: Ui) -> Steps:
    """Weight Paint within the act: the mesh follows a stroke. Enter right after another one waits for it and keeps all
    of it, which is one step of undo.
    """
    show_front(ui)
    ui.select(bar())
    bpy.ops.ed.undo_push(message="scene")
    yield from test_pose.begin(ui)
    free = scenes.key_positions(bar())
    yield from paint(ui, "Waist")
    yield from stroke(ui)
    yield from ui.until(lambda: np.abs(scenes.key_positions(bar()) - free).max() > 0.05, "the mesh follows")
    yield from ui.until(lambda: ui.running["Bar"].is_settled, "the act settles again")
    followed, n_painted = scenes.key_positions(bar()), np.count_nonzero(weights_of("Waist") > 0.5)
    yield from stroke(ui, MIDDLE + 0.8, then="RET")
    yield from ui.until(lambda: "Bar" not in ui.running, "the act ends")
    assert np.count_nonzero(weights_of("Waist") > 0.5) > n_painted
    assert np.abs(scenes.key_positions(bar()) - followed).max() > 0.05
    assert_as_solved(ui)
    yield from ui.undo()
    yield from ui.until(lambda: bar().mode == "OBJECT" and bar().data.shape_keys is None, "the act is undone")
    assert weights_of("Waist").max() == 0.0
