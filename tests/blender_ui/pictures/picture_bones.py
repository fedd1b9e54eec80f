# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of the user guide: an armature inside the sample creature moves it without weights. Run by .ci/pictures."""

from itertools import pairwise

import bpy
from camera import Camera, begin_pull, look, tidy_up
from harness import Steps, Ui

CHAINS = {
    "Spine": [(0.0, 0.30, 0.55), (0.0, -0.05, 0.58), (0.0, -0.30, 0.66)],
    "Neck": [(0.0, -0.30, 0.66), (0.0, -0.55, 0.95), (0.0, -0.80, 1.25)],
    "Tail": [(0.0, 0.30, 0.62), (0.0, 0.62, 0.85), (0.0, 0.80, 1.15), (0.0, 0.83, 1.50)],
    "Front L": [(0.19, -0.24, 0.55), (0.20, -0.22, 0.30), (0.20, -0.27, 0.05)],
    "Front R": [(-0.19, -0.24, 0.55), (-0.20, -0.22, 0.30), (-0.20, -0.27, 0.05)],
    "Hind L": [(0.20, 0.20, 0.52), (0.21, 0.24, 0.28), (0.21, 0.20, 0.05)],
    "Hind R": [(-0.20, 0.20, 0.52), (-0.21, 0.24, 0.28), (-0.21, 0.20, 0.05)],
}
CUT = ("-gravity", "center", "-crop", "690x0-60+0", "+repage", "-resize", "50%")
TURNS = {  # of bones, radian about their own x, y and z
    "Neck 2": (0.15, -0.6, 0.35),
    "Tail 2": (0.5, 0.0, 0.5),
    "Tail 3": (0.6, 0.0, 0.5),
    "Front L 1": (-1.1, 0.0, 0.0),
    "Front L 2": (1.0, 0.0, 0.0),
}


def skeleton() -> bpy.types.Object:
    data = bpy.data.armatures.new("Skeleton")
    armature = bpy.data.objects.new("Skeleton", data)
    bpy.context.scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    for name, points in CHAINS.items():
        parent = None
        for i, (head, tail) in enumerate(pairwise(points), 1):
            bone = data.edit_bones.new(f"{name} {i}")
            bone.head, bone.tail, bone.parent = head, tail, parent
            parent = bone
    bpy.ops.object.mode_set(mode="OBJECT")
    armature.show_in_front = True
    return armature


def test_picture_bones(ui: Ui) -> Steps:
    camera = Camera(ui)
    creature = yield from begin_pull(ui)
    ui.call(bpy.ops.wm.tool_set_by_id, "EXEC_DEFAULT", True, name="builtin.select_box")
    armature = skeleton()
    creature.select_set(True)
    armature.select_set(True)
    bpy.context.view_layer.objects.active = creature
    yield
    assert ui.call(bpy.ops.arap.bones_add) == {"FINISHED"}
    yield from ui.until(lambda: ui.follow.run_of(creature).is_settled, "it is bound")
    assert creature.arap.follow_error == ""
    tidy_up(ui.view.spaces.active)
    look(ui, right=-0.9, up=0.25, closer=0.9)
    yield from camera.view("guide-bones-1", *CUT)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="POSE")
    for name, turn in TURNS.items():
        bone = armature.pose.bones[name]
        bone.rotation_mode = "XYZ"
        bone.rotation_euler = turn
    yield
    yield from ui.until(lambda: ui.follow.run_of(creature).is_settled, "the mesh follows")
    yield from camera.view("guide-bones-2", *CUT)
