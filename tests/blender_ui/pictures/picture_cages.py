# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of the user guide: the sample creature in a cage, its head pulled. Run by .ci/pictures."""

import bpy
from camera import Camera, begin_pull, look, tidy_up
from harness import Steps, Ui
from test_follow import make_cage, move_selected
from test_pose import select_vertices

CUT = ("-gravity", "center", "-crop", "690x0-60+0", "+repage", "-resize", "50%")


def test_picture_cage(ui: Ui) -> Steps:
    camera = Camera(ui)
    yield from begin_pull(ui)
    ui.call(bpy.ops.wm.tool_set_by_id, "EXEC_DEFAULT", True, name="builtin.select_box")
    tidy_up(ui.view.spaces.active)
    cage = yield from make_cage(ui)
    look(ui, right=-0.9, up=0.2, closer=0.9)
    bpy.ops.object.mode_set(mode="EDIT")
    top = max(vertex.co.z for vertex in cage.data.vertices)
    select_vertices(cage, [v.index for v in cage.data.vertices if v.co.z > 0.75 * top and v.co.y < 0.0])
    yield from ui.move_mouse_to_view()
    tools = bpy.context.scene.tool_settings
    tools.use_proportional_edit, tools.proportional_size = True, 0.6
    yield from move_selected(ui, "Z", ".4")
    yield
    yield from camera.view("guide-cage", *CUT)
