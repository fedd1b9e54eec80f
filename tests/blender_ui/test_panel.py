# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar tab, menus, preferences and the search: what is drawn, and what buttons do."""

from typing import Any

import bpy
import numpy as np
import scenes
from camera import begin_pull, look, open_creature
from harness import Steps, Ui
from test_follow import make_cage, move_selected
from test_overlay import show_all
from test_pose import bar, begin, drag, handle, select_vertices
from test_weight_paint import take_brush

PANELS = ("entry", "stiffness", "stats", "advanced")


def test_all_is_drawn(ui: Ui) -> Steps:
    """The tab in every state, menus and preferences: the pictures are for eyes, a traceback fails the test."""
    ui.open_panels(*(f"ARAP_PT_{name}" for name in PANELS))
    yield from draw_states_of_the_tab(ui)
    yield from draw_settings(ui)
    yield from draw_menus(ui)
    yield from draw_preferences(ui)
    yield from draw_creature(ui)
    yield from draw_cage(ui)


def draw_states_of_the_tab(ui: Ui) -> Steps:
    """Nothing, a new mesh, handles and pins, posing, after it, groups without weights, a handle without an object."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    yield from ui.open_tab()
    yield from ui.screenshot("1_no_mesh")
    scenes.add_bar()
    yield from ui.screenshot("2_new_mesh")
    bpy.ops.object.mode_set(mode="EDIT")
    yield from ui.screenshot("2_edit_mode")
    bpy.ops.object.mode_set(mode="OBJECT")
    ui.api.add_pin(bar(), scenes.bottom(), name="Bottom")
    bpy.ops.object.mode_set(mode="EDIT")
    yield from ui.screenshot("2_pinned")
    bpy.ops.object.mode_set(mode="OBJECT")
    ui.api.add_handle(bar(), scenes.top(), name="Top")
    yield from ui.screenshot("3_ready")
    ui.select(handle())
    yield from begin(ui)
    yield from drag(ui)
    yield from ui.screenshot("4_posing")
    yield from ui.key("RET")
    yield from ui.screenshot("5_posed")
    for group in ("Top", "Bottom"):
        bar().vertex_groups[group].remove(range(len(bar().data.vertices)))
    yield from ui.screenshot("6_groups_without_weights")
    bpy.data.objects.remove(handle())
    ui.select(bar())
    yield from ui.screenshot("7_handle_without_object")


def draw_settings(ui: Ui) -> Steps:
    """Rigidity and Exact show with the energy they belong to, Cube Size with a solid; so does what nothing holds."""
    scenes.add_bar_with_handle(ui.api)
    ui.api.add_handle(bar(), [24], name="Point", use_exact=True)
    ui.api.add_stiffness(bar(), range(16, 32), name="Belly", factor=10.0)
    bar().data.vertices.add(1)
    assert ui.api.solve(bar()).loose_vertices == 1
    yield from ui.screenshot("look")
    yield from ui.scroll_tab()
    bar().scale = (2.0, 2.0, 2.0)
    yield from ui.screenshot("settings")
    bar().arap.energy = "spokes"
    ui.region("UI").tag_redraw()  # a script does not, as a click does
    yield from ui.screenshot("settings_of_a_classic")
    bar().arap.model = "solid"
    ui.region("UI").tag_redraw()
    yield from ui.screenshot("settings_of_a_solid")


def draw_menus(ui: Ui) -> Steps:
    """Of the right button, which has a menu of ours in each mode."""
    for mode in ("OBJECT", "EDIT", "WEIGHT_PAINT"):
        ui.select(bar())
        bpy.ops.object.mode_set(mode=mode)
        if mode == "WEIGHT_PAINT":
            yield from take_brush(ui)  # Blender's own menu cannot be drawn without
        yield from ui.move_mouse_to_view()
        yield from ui.key("RIGHTMOUSE")
        yield from ui.screenshot(mode.lower())
        yield from ui.key("ESC")
        yield
        ui.call(bpy.ops.wm.call_menu, "INVOKE_DEFAULT", True, name="ARAP_MT_context")
        yield from ui.screenshot(f"{mode.lower()}_menu")
        yield from ui.key("ESC")
        yield
        bpy.ops.object.mode_set(mode="OBJECT")


def draw_preferences(ui: Ui) -> Steps:
    """Pins and handles in the colours of the theme, and the page of the add-on."""
    bar().arap.overlay.show_pins = bar().arap.overlay.show_handles = True
    yield from ui.screenshot("colors")
    area = yield from ui.turn_view_into_preferences()
    yield from ui.screenshot("page")
    area.type = "VIEW_3D"
    yield


def draw_creature(ui: Ui) -> Steps:
    """The sample creature in a frame of its animation, and all of the tab."""
    ui.change(bpy.context.preferences.view, "ui_scale", 0.8)
    creature = yield from open_creature(ui)
    show_all(creature)
    bpy.context.scene.frame_set(24)
    assert ui.call(bpy.ops.arap.solve, "EXEC_DEFAULT", True) == {"FINISHED"}
    ui.call(bpy.ops.view3d.view_selected)
    yield from ui.screenshot("creature")
    assert creature.arap.follow_error == ""


def draw_cage(ui: Ui) -> Steps:
    """The creature in its cage: made, edited with O."""
    yield from begin_pull(ui)
    look(ui, right=-0.9, up=0.25)
    cage = yield from make_cage(ui)
    yield from ui.screenshot("cage_made")
    bpy.ops.object.mode_set(mode="EDIT")
    select_vertices(cage, [v.index for v in cage.data.vertices if v.co.z > 1.4])
    bpy.ops.ed.undo_push(message="selected")
    yield from ui.move_mouse_to_view()
    bpy.context.scene.tool_settings.use_proportional_edit = True
    bpy.context.scene.tool_settings.proportional_size = 0.7
    yield from move_selected(ui, "Y", "-.4")
    yield from ui.screenshot("cage_edited")
    bpy.ops.object.mode_set(mode="OBJECT")


def test_search_finds_the_acts(ui: Ui) -> Steps:
    """F3, a name, Enter."""
    scenes.add_bar_with_handle(ui.api)
    yield from ui.move_mouse_to_view()
    yield from ui.key("F3")
    yield
    yield from ui.text("arap solve")
    yield
    yield from ui.screenshot("search")
    handle().location.x = 1.0
    yield from ui.key("RET")
    yield from ui.until(
        lambda: ui.sessions.stats(bar().session_uid) is not None,
        "the search has run ARAP Solve",
    )


def test_adjust_last_operation_changes_what_was_added(ui: Ui) -> Steps:
    """Pins, handles and stiffness, in Edit and Object Mode: one step of undo, whose options can be changed."""
    scenes.add_bar_with_handle(ui.api)
    yield from ui.move_mouse_to_view()
    yield from ui.key("TAB")
    select_vertices(bar(), list(range(16, 32)))
    bpy.ops.ed.undo_push(message="selected")
    yield from add_and_adjust(ui, bpy.ops.arap.handle_add, "handles", "OBJECT", name="Nose", use_exact=True)
    yield from add_and_adjust(ui, bpy.ops.arap.pin_add, "pins", name="Heel")
    yield from add_and_adjust(
        ui, bpy.ops.arap.stiffness_add, "stiffness", name="Helmet", use_rigid=True, use_single_body=True
    )
    yield from add_and_adjust(ui, bpy.ops.arap.stiffness_add, "stiffness", name="Belly")
    yield from ui.key("TAB")
    bar().vertex_groups.clear()  # or there is a dialog first
    bpy.ops.ed.undo_push(message="no groups")
    yield from add_and_adjust(ui, bpy.ops.arap.stiffness_add, "stiffness", name="Belly")
    ui.call(bpy.ops.arap.control_remove)
    assert len(bar().arap.handles) == 0
    yield from ui.undo()
    assert len(bar().arap.handles) == 1


def test_adjust_last_operation_makes_another_cage(ui: Ui) -> Steps:
    """The first one goes; undo leaves none."""
    scenes.add_bar_with_handle(ui.api)
    yield from ui.move_mouse_to_view()
    bpy.ops.ed.undo_push(message="bar")
    cage = yield from make_cage(ui)
    n_vertices = len(cage.data.vertices)
    bpy.context.window_manager.operators[-1].properties.cells = 2
    assert ui.call(bpy.ops.ed.undo_redo, "EXEC_DEFAULT", True) == {"FINISHED"}
    yield
    cages = [obj for obj in bpy.data.objects if "Cage" in obj.name]
    assert [modifier.object for modifier in bar().modifiers] == cages
    assert len(cages) == 1
    assert len(cages[0].data.vertices) < n_vertices
    yield from ui.undo()
    assert ["Cage" in obj.name for obj in bpy.data.objects] == [False, False]
    assert not bar().modifiers


def add_and_adjust(ui: Ui, add: Any, items: str, mode_after: str = "", **options: object) -> Steps:
    """Adds to a list, changes options in Adjust Last Operation, and takes it back. ``mode_after``: '' for the same."""
    mode, n_entries = bar().mode, len(getattr(bar().arap, items))
    mode_after = mode_after or mode
    ui.call(add)
    yield from ui.until(lambda: bar().mode == mode_after, "the mode is the right one")
    for name, value in options.items():
        operator = bpy.context.window_manager.operators[-1]
        assert operator.bl_idname == add.idname()
        setattr(operator.properties, name, value)
        assert ui.call(bpy.ops.ed.undo_redo, "EXEC_DEFAULT", True) == {"FINISHED"}
        yield from ui.until(lambda: bar().mode == mode_after, "the mode is the right one")
        entries = getattr(bar().arap, items)
        assert len(entries) == n_entries + 1
        assert getattr(entries[-1], name) == value
    yield from ui.undo()
    yield from ui.until(lambda: len(getattr(bar().arap, items)) == n_entries, "it is taken back")
    yield from ui.until(lambda: bar().mode == mode, "the mode is as before")


def test_a_new_handle_is_in_hand_and_the_mesh_follows(ui: Ui) -> Steps:
    """From vertices to a pose: Add Handle, G. The object stays where it is. Undo is exact, Cancel puts all back."""
    scenes.add_bar()
    ui.api.add_pin(bar(), scenes.bottom(), name="Bottom")
    yield from ui.open_tab()
    yield from ui.key("TAB")
    select_vertices(bar(), scenes.top())
    bpy.ops.ed.undo_push(message="selected")
    ui.call(bpy.ops.arap.handle_add)
    yield
    assert (bpy.context.object, bar().mode, bar().select_get()) == (handle(), "OBJECT", False)
    assert bpy.context.object.select_get()
    yield from ui.until(lambda: ui.follow.run_of(bar()).is_settled, "the mesh is ready")
    yield from drag(ui)
    yield from ui.until(lambda: top_x() > 0.9, "the mesh follows")
    assert tuple(bar().location) == (0.0, 0.0, 0.0)
    yield from ui.screenshot("followed")
    yield from ui.undo()
    yield from ui.until(lambda: abs(top_x()) < 1e-5, "undo takes the move back")
    yield from ui.redo()
    yield from ui.until(lambda: top_x() > 0.9, "and redo brings it")
    ui.select(bar())
    yield from ui.screenshot("mesh_selected")


def top_x() -> float:
    return float(scenes.shown_positions(bar())[scenes.top(), 0].mean())


def test_select_is_one_step_of_undo(ui: Ui) -> Steps:
    """In Edit Mode, of which it leaves nothing behind but what is selected; undo brings back what was."""
    obj = scenes.add_bar_with_handle(ui.api)
    yield from ui.move_mouse_to_view()
    yield from ui.key("TAB")
    assert obj.mode == "EDIT"
    selected = lambda: ui.meshes.selected_vertices(bar()).tolist()  # noqa: E731
    ui.call(bpy.ops.mesh.select_all, "EXEC_DEFAULT", True, action="SELECT")
    assert ui.call(bpy.ops.arap.group_select, "EXEC_DEFAULT", True, vertex_group="Bottom") == {"FINISHED"}
    yield
    assert selected() == scenes.bottom()
    yield from ui.undo()
    yield from ui.until(lambda: len(selected()) == len(bar().data.vertices), "it is undone")
    assert bar().mode == "EDIT"
    yield from ui.redo()
    yield from ui.until(lambda: selected() == scenes.bottom(), "it is done again")
    assert bar().mode == "EDIT"


def test_solve_shows_how_far_it_is_and_esc_ends_it(ui: Ui) -> Steps:
    """A solve that takes long leaves Blender alive; Esc leaves the mesh as it was, and nothing else ends it."""
    obj = scenes.add_held_grid(ui.api)
    target = obj.arap.handles[0].target
    target.location.z, target.rotation_euler.x = 1.0, 2.0  # one iteration is not enough
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="scene")
    yield from ui.open_tab()
    for after in (0.0, ui.solve.BIND_SHARE):  # Esc while the mesh is bound, then while it is solved
        with ui.held_stage(after=after):
            ui.call(bpy.ops.arap.solve)
            job = ui.running["Grid"]
            assert job.doing == "it is solved"
            yield from ui.until_held()
            yield from ui.until(lambda job=job, after=after: job.fraction > after, "the solver tells how far it is")
            yield from ui.screenshot("working")
            yield from ui.key("ESC")
            yield from ui.until_free()
        assert obj.data.shape_keys is None
        assert ui.sessions.stats(obj.session_uid) is None
    ui.call(bpy.ops.arap.solve)
    yield from ui.until_free()
    assert ui.sessions.stats(obj.session_uid) is not None
    np.testing.assert_allclose(scenes.shown_positions(obj)[-20:, 2], 1.0, atol=1e-4)
    yield
    yield from ui.undo()
    assert bpy.data.objects["Grid"].data.shape_keys is None, "one step of undo"
