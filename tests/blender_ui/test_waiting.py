# SPDX-License-Identifier: GPL-3.0-or-later
"""The bar in the views while a mesh is prepared, and Esc."""

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import rna_xml
import scenes
import test_live
import test_pull
from harness import Steps, Ui

THEMES = Path(bpy.utils.system_resource("SCRIPTS")) / "presets" / "interface_theme"


def count_drawn(ui: Ui) -> list[str]:
    """The texts of the bars that are drawn from now on."""
    texts: list[str] = []
    draw = ui.waiting.draw_wait

    def noting_draw(context: bpy.types.Context, wait: object) -> None:
        draw(context, wait)
        texts.append(wait.text)

    ui.change(ui.waiting, "draw_wait", noting_draw)
    return texts


def until_drawn(ui: Ui, texts: list[str], begins_with: str) -> Steps:
    """Within held_stage(): waits for the bar."""
    yield from ui.until_held()
    yield from ui.until(lambda: bool(texts), "the bar is drawn")
    assert texts[-1].startswith(begins_with), texts


def cancel(ui: Ui, is_over: Callable[[], bool]) -> Steps:
    """Esc ends the work, and the bar."""
    yield from ui.key("ESC")
    yield from ui.until(is_over, "Esc has ended it")
    yield from ui.until(lambda: ui.waiting.shown() is None, "the bar is gone")


def set_theme(name: str) -> None:
    rna_xml.xml_file_run(bpy.context, str(THEMES / f"{name}.xml"), (("preferences.themes[0]", "Theme"),))


def test_waiting_for_a_mesh_that_follows(ui: Ui) -> Steps:
    """The bar is over the view, in every theme and size. Esc switches Follow off and nothing moves."""
    yield from test_live.begin(ui)
    shown = scenes.shown_positions(test_live.bar())
    texts = count_drawn(ui)
    test_live.bar().arap.overlay.show_strain = True
    assert not ui.can(bpy.ops.arap.follow_cancel), "else Esc is not Blender's own"
    with ui.held_stage():
        ui.sessions.drop("Bar")
        bpy.data.objects["Top"].location.x += 1.0
        yield from until_drawn(ui, texts, "Preparing Bar, ")
        yield from ui.screenshot("dark")
        ui.change(bpy.context.preferences.view, "ui_scale", 2.0)
        yield from ui.screenshot("dark_200")
        set_theme("Blender_Light")
        yield from ui.screenshot("light_200")
        bpy.context.preferences.view.ui_scale = 1.0
        yield from ui.screenshot("light")
        set_theme("Blender_Dark")
        yield from cancel(ui, lambda: not test_live.bar().arap.is_live)
    np.testing.assert_array_equal(scenes.shown_positions(test_live.bar()), shown)
    assert not test_live.bar().arap.live_problem
    assert not ui.can(bpy.ops.arap.follow_cancel)
    test_live.bar().arap.is_live = True
    yield from test_live.settle(ui)
    test_live.assert_followed(ui)


def test_waiting_for_acts(ui: Ui) -> Steps:
    """Pose, Solve and Bake show the bar too, and Esc ends them."""
    scenes.add_held_grid(ui.api)
    yield from ui.move_mouse_to_view()
    texts = count_drawn(ui)
    for operator, properties, begins_with in (
        (bpy.ops.arap.pose, {}, "Preparing Grid, "),
        (bpy.ops.arap.solve, {}, "Solve: preparing the mesh, "),
        (bpy.ops.arap.bake_animation, {"frame_start": 1, "frame_end": 9}, "Bake: preparing the mesh, "),
    ):
        texts.clear()
        with ui.held_stage():
            ui.call(operator, "EXEC_DEFAULT" if properties else "INVOKE_DEFAULT", True, **properties)
            yield from until_drawn(ui, texts, begins_with)
            yield from ui.screenshot(operator.idname_py().rpartition(".")[2])
            yield from cancel(ui, lambda: not ui.running)


def test_waiting_for_a_pull(ui: Ui) -> Steps:
    yield from test_pull.begin(ui, 21)
    texts = count_drawn(ui)
    with ui.held_stage():
        yield from test_pull.grab(ui, (0.3, 0.0, 0.0), (0.3, 0.2, 0.0), 2)
        yield from until_drawn(ui, texts, "Preparing Grid, ")
        yield from ui.screenshot("bar")
        yield from cancel(ui, lambda: not ui.running)
    ui.event("LEFTMOUSE", "RELEASE")
    yield
    assert test_pull.sheet().data.shape_keys is None
