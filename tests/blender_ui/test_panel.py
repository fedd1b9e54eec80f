# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar tab and the search, looked at; the pictures are for eyes, a traceback while drawing fails the test."""

import bpy
import scenes
from harness import Steps, Ui
from test_pose import bar, begin, drag, handle, settle


def test_panel(ui: Ui) -> Steps:
    """The tab draws in every state: nothing, a new mesh, handles and pins, a broken handle, posing, after it."""
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
    yield from drag(ui, "G", "X", "1")
    yield from settle(ui)
    yield from ui.screenshot("4_posing")
    yield from ui.key("RET")
    yield from ui.screenshot("5_posed")
    for group in ("Top", "Bottom"):
        bar().vertex_groups[group].remove(range(len(bar().data.vertices)))
    yield from ui.screenshot("6_groups_without_weights")
    bpy.data.objects.remove(handle())
    ui.select(bar())
    yield from ui.screenshot("7_handle_without_object")


def test_settings_and_look(ui: Ui) -> Steps:
    """The panels that are closed at first, opened; Rigidity and Exact show with the energy they belong to."""
    scenes.add_bar_with_handle(ui.api)
    ui.api.add_handle(bar(), [24], name="Point", is_exact=True)
    for name in ("ARAP_PT_handle_look", "ARAP_PT_settings"):
        panel = getattr(bpy.types, name)
        bpy.utils.unregister_class(panel)
        panel.bl_options = set()
        bpy.utils.register_class(panel)
    yield from ui.open_tab()
    yield from ui.screenshot("look")
    region = ui.region("UI")
    yield from ui.move_mouse(region.x + region.width // 3, region.y + region.height // 2)
    for _ in range(12):
        ui.event("WHEELDOWNMOUSE")
        yield
    yield from ui.screenshot("settings")
    bar().scale = (2.0, 2.0, 2.0)
    yield from ui.screenshot("settings_of_a_larger_bar")
    bar().arap.energy = "spokes"
    ui.region("UI").tag_redraw()  # a script does not, as a click does
    yield from ui.screenshot("settings_of_a_classic")


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
    yield
    assert ui.api.readout(bar()) is not None, "the search ran ARAP Solve"
