# SPDX-License-Identifier: GPL-3.0-or-later
"""After Object > Apply to a mesh its handles hold it where it was."""

import contextlib
import io
from unittest import mock

import numpy as np
from looks import in_world, rest_positions, shown_positions
from support import SceneTest, bpy, module, opened_again
from tubes import MIDDLE, PLACED, Matrix, armature, bend, move, posable, solved

SCALE = {"location": False, "rotation": False, "scale": True}
TURN = {"location": False, "rotation": True, "scale": False}
PLACE = {"location": True, "rotation": False, "scale": False}
ALL = {"location": True, "rotation": True, "scale": True}


def apply(obj, which=ALL):
    """As the artist does."""
    bpy.context.view_layer.update()
    with bpy.context.temp_override(active_object=obj, selected_editable_objects=[obj]):
        bpy.ops.object.transform_apply(**which)
    bpy.context.view_layer.update()


def world_of(obj):
    return in_world(obj, shown_positions(obj))


class AppliedTest(SceneTest):
    def assert_stays(self, obj, which=ALL):
        """When it is applied, and when the mesh is solved after that."""
        before, former = world_of(obj), rest_positions(obj)
        apply(obj, which)
        self.assertGreater(np.abs(rest_positions(obj) - former).max(), 0.1)
        self.assert_close(world_of(obj), before)
        self.api.solve(obj)
        self.assert_close(world_of(obj), before, 2e-5)

    def test_scale_turn_and_place_of_a_mesh_at_rest_and_posed(self):
        turned, stretched = Matrix.Rotation(0.7, 4, "Y"), Matrix.Diagonal((1.0, 2.0, 0.5, 1.0))
        for matrix, which in ((PLACED, ALL), (stretched, SCALE), (turned, TURN), (PLACED, PLACE)):
            for make in (posable, solved):
                self.setUp()
                obj = make(matrix=matrix)
                self.api.solve(obj)
                self.assert_stays(obj, which)

    def test_after_the_object_was_moved(self):
        """By the artist, by its animation, and by that of its parent."""
        for is_animated, is_child in ((False, False), (True, False), (True, True)):
            self.setUp()
            obj = solved(matrix=Matrix.Diagonal((1.0, 2.0, 0.5, 1.0)))
            moved = obj
            if is_child:
                moved = obj.parent = bpy.data.objects.new("Parent", None)
                self.scene.collection.objects.link(moved)
            for frame, x in ((1, 0.0), (5, 3.0)):
                moved.location.x = x
                if is_animated:
                    moved.keyframe_insert("location", frame=frame)
            if is_animated:
                self.scene.frame_set(5)
            bpy.context.view_layer.update()
            self.api.solve(obj)
            self.assert_stays(obj, SCALE)

    def test_set_origin_is_the_same(self):
        obj = solved(matrix=PLACED)
        before = world_of(obj)
        with bpy.context.temp_override(active_object=obj, object=obj, selected_editable_objects=[obj]):
            bpy.ops.object.origin_set(type="ORIGIN_GEOMETRY")
        self.api.solve(obj)
        self.assertGreater(np.abs(rest_positions(obj)[:, 2].min()), 1.0)
        self.assert_close(world_of(obj), before, 2e-5)

    def test_what_was_added_to_a_pose_holds_that(self):
        obj = solved(matrix=PLACED)
        self.api.add_pin(obj, MIDDLE, name="Waist")
        self.api.solve(obj)
        self.assertTrue(obj.arap.pins[1].base_id)
        self.assert_stays(obj)

    def test_a_pin_alone(self):
        obj = solved(matrix=PLACED)
        self.api.add_pin(obj, MIDDLE, name="Waist")
        self.api.remove_control(obj, obj.arap.handles[0].name)
        bpy.context.view_layer.update()
        base = obj.arap.controls["Waist"].base[1]
        turn = np.array(obj.matrix_world.to_3x3())
        apply(obj)
        bpy.context.view_layer.update()
        self.assert_close(obj.arap.controls["Waist"].base[1], base @ turn.T, 1e-5)

    def test_a_bone_without_a_group(self):
        obj = posable(matrix=PLACED)
        obj.arap.model = "solid"
        obj.arap.handles[0].is_enabled = False
        rig = armature(PLACED)
        self.api.add_bones(obj, rig, ["Upper"])
        rig.pose.bones["Upper"].rotation_mode = "XYZ"
        rig.pose.bones["Upper"].rotation_euler.x = 0.8
        self.api.solve(obj)
        self.assert_stays(obj, SCALE)  # turned, the mesh would have other cubes

    def test_stored_poses(self):
        obj = solved(matrix=PLACED)
        before = world_of(obj)
        self.api.store_pose(obj, "Bent")
        self.api.reset_handles(obj)
        self.api.solve(obj)
        self.assert_stays(obj)
        self.api.apply_pose(obj, "Bent")
        self.api.solve(obj)
        self.assert_close(world_of(obj), before, 2e-5)

    def test_a_mesh_that_follows(self):
        obj = posable(matrix=PLACED)
        obj.arap.use_follow = True
        bend(obj)
        before = world_of(obj)
        self.assertGreater(np.abs(before - in_world(obj, rest_positions(obj))).max(), 0.3)
        apply(obj)
        self.assertTrue(obj.arap.use_follow)
        self.assert_close(world_of(obj), before, 1e-3)

    def test_undo_redo_and_a_saved_file(self):
        obj = solved(matrix=PLACED)
        before = world_of(obj)
        bpy.ops.ed.undo_push(message="posed")
        with bpy.context.temp_override(active_object=obj, selected_editable_objects=[obj]):
            bpy.ops.object.transform_apply()
        bpy.ops.ed.undo_push(message="applied")  # as Blender does, before it evaluates
        bpy.context.view_layer.update()
        for step in (bpy.ops.ed.undo, bpy.ops.ed.redo, opened_again):
            step()
            obj = bpy.data.objects["Tube"]
            self.api.solve(obj)
            self.assert_close(world_of(obj), before, 2e-5)

    def test_scaled_flat(self):
        """Where its handles rest cannot be told any more: their list says so, and other meshes go on."""
        obj, other = solved(), posable("Other")
        other.arap.use_follow = True
        self.api.store_pose(obj, "Bent")
        obj.scale.z = 0.0
        with contextlib.redirect_stderr(io.StringIO()) as said:
            apply(obj)
            move(other.arap.handles[0].target, (0.0, 0.5, 0.0))
        self.assertEqual(said.getvalue(), "")
        self.assertGreater(np.abs(shown_positions(other) - rest_positions(other)).max(), 0.4)
        self.assertRegex(
            module("setup.controls").control_problem(obj, obj.arap.handles[0]),
            "^Handle 'Head' of 'Tube': .* choose it again$",
        )

    def test_a_fault_with_one_mesh_keeps_no_other_from_its_turn(self):
        broken, obj = posable("Broken", PLACED), solved("Tube", PLACED)
        before, look = world_of(obj), module("engine.applied").look

        def fails(each):
            if each.name == "Broken":
                raise KeyError(each.name)
            look(each)

        for select in (broken, obj):
            select.select_set(True)
        with (
            mock.patch.object(module("engine.applied"), "look", fails),
            contextlib.redirect_stderr(io.StringIO()) as said,
        ):
            with bpy.context.temp_override(active_object=obj, selected_editable_objects=[broken, obj]):
                bpy.ops.object.transform_apply()
            bpy.context.view_layer.update()
        self.assertIn("KeyError: 'Broken'", said.getvalue())
        self.api.solve(obj)
        self.assert_close(world_of(obj), before, 2e-5)

    def test_what_is_moved_or_edited_alone_keeps_its_handles_rest(self):
        obj = posable(matrix=PLACED)
        rest = obj.arap.handles[0].rest.copy()
        obj.location.x += 1.0
        bpy.context.view_layer.update()
        for vertex in obj.data.vertices:
            vertex.co *= 2.0
        obj.data.update()
        bpy.context.view_layer.update()
        self.assertEqual(obj.arap.handles[0].rest, rest)
