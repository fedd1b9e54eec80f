# SPDX-License-Identifier: GPL-3.0-or-later
"""What happens to files, scenes, windows and names while a mesh is posed, pulled or live."""

import tempfile
from pathlib import Path

import bpy
import numpy as np
import scenes
import test_live
import test_pull
from harness import Steps, Ui
from test_pose import assert_followed, bar, begin, drag, handle, settle

NEAR = 1e-5


def begin_moved(ui: Ui) -> Steps:
    """The act, its handle moved by one."""
    scenes.add_bar_with_handle(ui.api)
    ui.select(handle())
    yield from begin(ui)
    yield from drag(ui, "G", "X", "1")
    yield from settle(ui)


def test_new_file_within(ui: Ui) -> Steps:
    """File > New ends the act without a word, and what is in the new file can be posed."""
    yield from begin_moved(ui)
    ui.call(bpy.ops.wm.read_homefile, "EXEC_DEFAULT", use_factory_startup=True)
    yield from ui.until_free()
    yield from begin_moved(ui)
    yield from ui.key("RET")
    yield from ui.until_free()
    assert bar().data.shape_keys.key_blocks["ARAP"].value == 1.0


def test_renamed_mesh_within(ui: Ui) -> Steps:
    """The act ends and leaves the pose; under the new name posing goes on from it."""
    yield from begin_moved(ui)
    posed = scenes.key_positions(bar())
    bar().name = "Pole"
    yield from ui.until_free()
    pole = bpy.data.objects["Pole"]
    np.testing.assert_array_equal(scenes.key_positions(pole), posed)
    assert ui.call(bpy.ops.arap.pose) == {"RUNNING_MODAL"}
    yield from ui.until(lambda: "Pole" in ui.running and ui.running["Pole"].is_settled, "the act has bound")
    yield from drag(ui, "G", "X", "1")
    yield from ui.key("RET")
    yield
    top = scenes.key_positions(pole)[scenes.top()]
    np.testing.assert_allclose(top, posed[scenes.top()] + [1.0, 0.0, 0.0], atol=NEAR)


def test_append_and_link(ui: Ui) -> Steps:
    """An appended mesh brings its pins, handles and pose; a linked one is refused with what to do."""
    scenes.add_bar_with_handle(ui.api)
    handle().location.x = 1.0
    ui.api.solve(bar())
    posed = scenes.key_positions(bar())
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "library.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        for is_link in (False, True):
            ui.call(bpy.ops.wm.read_homefile, "EXEC_DEFAULT", use_factory_startup=True)
            yield
            for obj in list(bpy.data.objects):
                bpy.data.objects.remove(obj)
            with bpy.data.libraries.load(path, link=is_link) as (source, wanted):
                wanted.objects = [name for name in source.objects if name in {"Bar", "Top"}]
            for obj in wanted.objects:
                bpy.context.scene.collection.objects.link(obj)
            yield from ui.move_mouse_to_view()
            ui.select(bpy.data.objects["Bar"])
            if is_link:
                break
            np.testing.assert_array_equal(scenes.key_positions(bar()), posed)
            ui.select(handle())
            yield from begin(ui)
            yield from drag(ui, "G", "X", "1")
            yield from settle(ui)
            assert_followed(scenes.key_positions(bar(), "Basis"), (2.0, 0.0, 0.0))
            yield from ui.key("RET")
        assert not ui.can(bpy.ops.arap.pose)
        yield from ui.open_tab()
        yield from ui.screenshot("linked")
        np.testing.assert_array_equal(scenes.key_positions(bar()), posed)


def test_other_scene_within(ui: Ui) -> Steps:
    """Another scene in the window ends the act, with the pose kept; Live waits and goes on."""
    yield from begin_moved(ui)
    rest = scenes.key_positions(bar(), "Basis")
    first = bpy.context.scene
    other = bpy.data.scenes.new("Other scene")
    ui.window.scene = other
    yield from ui.until_free()
    handle().location.x += 1.0
    yield
    ui.window.scene = first
    yield
    assert_followed(rest, (1.0, 0.0, 0.0))
    bar().arap.is_live = True
    yield from test_live.settle(ui)
    test_live.assert_followed(ui)
    ui.window.scene = other
    yield
    yield
    handle().location.x -= 1.0
    ui.window.scene = first
    yield from test_live.settle(ui)
    test_live.assert_followed(ui)


def test_two_windows(ui: Ui) -> Steps:
    """A second window on the same scene: the act goes on, both draw, and closing either is no accident."""
    yield from begin_moved(ui)
    rest = scenes.key_positions(bar(), "Basis")
    ui.call(bpy.ops.wm.window_new_main, "EXEC_DEFAULT", True)
    yield
    yield
    yield from ui.screenshot("both")
    assert len(bpy.context.window_manager.windows) == 2
    handle().location.x += 1.0
    yield from settle(ui)
    assert_followed(rest, (2.0, 0.0, 0.0))
    second = bpy.context.window_manager.windows[1]
    with ui.override(window=second):
        bpy.ops.wm.window_close()
    yield
    handle().location.x += 1.0
    yield from settle(ui)
    assert "Bar" in ui.running
    assert_followed(rest, (3.0, 0.0, 0.0))
    yield from ui.key("ESC")
    yield from ui.until_free()


def test_new_file_within_a_pull(ui: Ui) -> Steps:
    """File > New with the button down: the drag is over, and the tool works in the new file."""
    yield from test_pull.begin(ui)
    yield from test_pull.press(ui, (0.3, 0.0, 0.0))
    yield from test_pull.drag_to(ui, (0.5, 0.3, 0.0))
    ui.call(bpy.ops.wm.read_homefile, "EXEC_DEFAULT", use_factory_startup=True)
    yield from ui.until_free()
    ui.event("LEFTMOUSE", "RELEASE")
    yield
    yield from test_pull.begin(ui)
    rest = scenes.key_positions(test_pull.sheet())
    yield from test_pull.pull(ui, (0.3, 0.0, 0.0), (0.3, 0.4, 0.0))
    assert np.abs(scenes.shown_positions(test_pull.sheet()) - rest).max() > 0.2


def test_renamed_mesh_within_a_pull(ui: Ui) -> Steps:
    """A mesh that gets another name under the mouse ends the drag; the next one finds it."""
    yield from test_pull.begin(ui)
    yield from test_pull.press(ui, (0.3, 0.0, 0.0))
    yield from test_pull.drag_to(ui, (0.5, 0.3, 0.0))
    sheet = test_pull.sheet()
    sheet.name = "Cloth"
    yield from ui.until_free()
    ui.event("LEFTMOUSE", "RELEASE")
    yield
    before = scenes.shown_positions(sheet)
    assert np.isfinite(before).all()
    yield from test_pull.pull(ui, (-0.5, -0.5, 0.0), (-0.5, -0.1, 0.0))
    assert np.abs(scenes.shown_positions(sheet) - before).max() > 0.2
