# SPDX-License-Identifier: GPL-3.0-or-later
"""Stored poses: the handles come back to where they were, whatever they are and whatever has changed since."""

import numpy as np
from looks import key_positions, rest_positions
from mathutils import Matrix, Vector
from support import SceneTest, bpy, module, opened_again
from tubes import BOTTOM, MIDDLE, PLACED, TOP, armature, bend, copied, empty_at, mesh_object, move, posable, solved


def places(obj) -> np.ndarray:
    """(h, 4, 4) world matrices of the handles' objects and bones, evaluated."""
    bpy.context.view_layer.update()
    result = []
    for handle in obj.arap.handles:
        matrix = handle.target.matrix_world
        result.append(np.array(matrix @ handle.target.pose.bones[handle.bone].matrix if handle.bone else matrix))
    return np.array(result)


def with_pose(api, name="Bent"):
    """The bent tube with its pose stored; returns the places of the handles too."""
    obj = posable()
    bend(obj)
    api.store_pose(obj, name)
    return obj, places(obj)


class PollTest(SceneTest):
    def test_poses_whose_handles_are_gone_can_be_deleted(self):
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        self.api.store_pose(obj, "Pose")
        self.api.remove_control(obj, obj.arap.handles[0].name)
        self.assertFalse(bpy.ops.arap.poses_apply.poll())
        self.assertEqual(bpy.ops.arap.poses_delete(), {"FINISHED"})
        self.assertEqual(len(obj.arap.poses), 0)
        self.assertFalse(bpy.ops.arap.poses_delete.poll())


class BlendRunTest(SceneTest):
    def test_a_mesh_that_was_changed_meanwhile_does_not_keep_a_drag_from_ending(self):
        obj, _ = with_pose(self.api)
        self.api.reset_handles(obj)
        self.api.solve(obj)
        before = places(obj)

        def blend(mesh, factor):
            return self.api.blend_poses(mesh, self.api.REST, "Bent", factor)

        locked_by = module("core.sessions").locked_by
        run = module("poses.blend_run").BlendRun(bpy.context, obj, blend, mouse_x=0, is_followed=False)
        self.assertEqual(locked_by(obj.session_uid), "its poses are blended")
        run.set_factor(1.0)
        self.assertGreater(np.abs(places(obj) - before).max(), 0.1)
        obj.data.vertices.add(1)
        for _ in range(2):  # a second call does no harm
            self.assertEqual(run.abort(), "'Tube' has 137 vertices, but had 136: its shape key stays")
            self.assertEqual(locked_by(obj.session_uid), "")
            self.assert_close(places(obj), before)


class ApplyTest(SceneTest):
    def check_round_trip(self, obj):
        stored = places(obj)
        self.api.solve(obj)
        shape = key_positions(obj)
        pose = self.api.store_pose(obj, "Bent")
        self.assertEqual(len(pose.motions), len(obj.arap.handles))
        self.api.reset_handles(obj)
        self.assertGreater(np.abs(places(obj) - stored).max(), 0.1)
        self.assertEqual(str(self.api.apply_pose(obj, "Bent")), "")
        self.assert_close(places(obj), stored, 1e-5)
        self.api.solve(obj)
        self.assert_close(key_positions(obj), shape, 1e-4)

    def test_objects_with_parents_that_are_handles_too(self):
        obj = posable(matrix=PLACED)
        arm, hand = empty_at((3.0, 0.0, 2.0), "Arm"), empty_at((4.0, 0.0, 3.0), "Hand")
        arm.scale = (2.0, 2.0, 2.0)
        hand.parent = arm
        bpy.context.view_layer.update()
        for empty in (hand, arm):  # the child stands before its parent in the list
            self.api.add_handle_for(obj, empty, radius=1.0)
        move(arm, (0.5, 0.0, 0.2), (0.3, 0.0, 0.5))
        move(hand, (0.0, 0.3, 0.0), (0.0, 0.6, 0.0))
        self.check_round_trip(obj)

    def test_bones(self):
        obj = mesh_object(matrix=PLACED)
        self.api.add_pin(obj, BOTTOM)
        rig = armature(PLACED)
        for name in ("Upper", "Lower"):
            self.api.add_handle_for(obj, rig, name, radius=0.8)
            rig.pose.bones[name].rotation_mode = "XYZ"
        obj.arap.max_iterations = 2000
        rig.pose.bones["Lower"].rotation_euler = (0.4, 0.2, 0.0)
        rig.pose.bones["Upper"].rotation_euler = (-0.6, 0.0, 0.5)
        rig.pose.bones["Upper"].scale = (1.2, 1.2, 1.2)
        self.check_round_trip(obj)

    def test_an_object_on_a_bone_that_is_a_handle(self):
        obj = mesh_object()
        rig = armature()
        empty = empty_at((0.0, 0.5, 4.0), "Hat")
        empty.parent, empty.parent_type, empty.parent_bone = rig, "BONE", "Upper"
        bpy.context.view_layer.update()
        self.api.add_handle_for(obj, empty, radius=0.5)
        self.api.add_handle_for(obj, rig, "Upper", radius=0.5)
        rig.pose.bones["Upper"].rotation_mode = "XYZ"
        rig.pose.bones["Upper"].rotation_euler.x = 0.5
        bpy.context.view_layer.update()
        move(empty, (0.2, 0.0, 0.0))
        self.check_round_trip(obj)

    def test_it_is_relative_to_the_mesh(self):
        """A mesh that stands elsewhere by now, larger, is posed there."""
        obj, _ = with_pose(self.api)
        before = module("scene.handle_motion").handle_matrices(obj)
        self.api.reset_handles(obj)
        obj.matrix_world = Matrix.Translation((5.0, 1.0, 0.0)) @ Matrix.Rotation(1.0, 4, "X") @ Matrix.Scale(2.0, 4)
        bpy.context.view_layer.update()
        self.assertEqual(str(self.api.apply_pose(obj, "Bent")), "")
        self.assert_close(module("scene.handle_motion").handle_matrices(obj), before, 2e-5)

    def test_a_handle_with_another_object_does_the_same_to_the_mesh(self):
        obj = solved()
        shape = key_positions(obj)
        self.api.store_pose(obj, "Bent")
        self.api.reset_handles(obj)
        self.api.solve(obj)
        obj.arap.handles[0].target = empty_at((2.0, 2.0, 2.0), "Other")
        self.assertEqual(str(self.api.apply_pose(obj, "Bent")), "")
        self.api.solve(obj)
        self.assert_close(key_positions(obj), shape, 1e-3)

    def test_a_new_rest_shape_leaves_the_places(self):
        obj, stored = with_pose(self.api)
        move(obj.arap.handles[0].target, (1.0, 0.0, 0.0), (0.0, 0.5, 0.0))
        self.api.solve(obj)
        self.api.apply_pose_as_rest(obj)
        self.api.apply_pose(obj, "Bent")
        self.assert_close(places(obj), stored, 1e-5)

    def test_handles_that_came_went_and_were_renamed(self):
        obj = posable()
        self.api.add_handle(obj, MIDDLE, name="Waist")
        bend(obj)
        move(obj.arap.handles[1].target, (0.2, 0.0, 0.0))
        stored = places(obj)[0]
        self.api.store_pose(obj, "Bent")
        self.api.remove_control(obj, obj.arap.handles[1].name)
        obj.arap.handles[0].name = "Crown"
        self.assertEqual(self.api.apply_pose(obj, "Bent").gone, ("Waist",))
        tail = obj.arap.controls[self.api.add_handle(obj, list(range(24, 32)), name="Tail")]
        tail_at = np.array(tail.target.matrix_world)
        move(obj.arap.handles[0].target, (0.0, 0.0, 1.0))
        placement = self.api.apply_pose(obj, "Bent")
        self.assert_close(places(obj)[0], stored, 1e-5)
        self.assert_close(places(obj)[1], tail_at, 0.0)
        self.assertEqual((placement.gone, placement.others, placement.held), (("Waist",), ("Tail",), ()))
        self.assertEqual(
            str(placement),
            "Not every handle is in the pose; deleted or unusable: Waist; not in the pose, so they stay: Tail",
        )

    def test_a_handle_made_anew_takes_the_place_of_the_lost_one_of_its_name(self):
        obj, stored = with_pose(self.api)
        self.api.reset_handles(obj)
        self.api.remove_control(obj, obj.arap.handles[0].name)
        self.api.add_handle(obj, TOP, name="Head")
        self.assertEqual(str(self.api.apply_pose(obj, "Bent")), "")
        self.assert_close(places(obj), stored, 1e-5)

    def test_handles_that_cannot_be_moved_are_named(self):
        obj = posable()
        self.api.add_handle(obj, MIDDLE, name="Waist")
        self.api.store_pose(obj, "Bent")
        head, waist = (handle.target for handle in obj.arap.handles)
        move(head, (1.0, 0.0, 0.0))
        head.constraints.new("LIMIT_LOCATION").use_min_x = True
        head.constraints[0].min_x = 0.5
        waist.hide_viewport = True
        self.assertEqual(
            str(self.api.apply_pose(obj, "Bent")),
            "Not every handle is in the pose; deleted or unusable: Waist; "
            "held by animation, a constraint, a driver or a sheared parent: Head",
        )

    def test_handles_of_the_same_name_are_not_mixed_up(self):
        obj = posable(matrix=PLACED)
        self.api.add_handle(obj, MIDDLE, name="Waist")
        obj.arap.handles[1].name = obj.arap.handles[0].name
        bend(obj)
        move(obj.arap.handles[1].target, (0.3, 0.0, 0.0), (0.0, 0.4, 0.0))
        self.check_round_trip(obj)

    def test_disabled_handles_are_part_of_a_pose(self):
        obj = posable()
        obj.arap.handles[0].is_enabled = False
        bend(obj)
        stored = places(obj)
        self.api.store_pose(obj, "Bent")
        self.api.reset_handles(obj)
        self.api.apply_pose(obj, "Bent")
        self.assert_close(places(obj), stored, 1e-5)

    def test_follow_follows(self):
        obj = solved()
        shape = key_positions(obj)
        self.api.store_pose(obj, "Bent")
        self.api.reset_handles(obj)
        obj.arap.use_follow = True
        bpy.context.view_layer.update()
        self.assert_close(key_positions(obj), rest_positions(obj), 1e-4)
        bpy.context.view_layer.objects.active = obj
        self.assertEqual(bpy.ops.arap.poses_apply(pose="Bent"), {"FINISHED"})
        bpy.context.view_layer.update()
        self.assert_close(key_positions(obj), shape, 1e-3)


class LibraryTest(SceneTest):
    def test_names_are_unique_and_never_empty(self):
        obj = posable()
        for _ in range(3):
            self.api.store_pose(obj, "Smile")
        poses = obj.arap.poses
        self.assertEqual([pose.name for pose in poses], ["Smile", "Smile.001", "Smile.002"])
        self.assertEqual(obj.arap.active_pose_index, 2)
        poses[2].name = "Smile"
        self.assertEqual(poses[2].name, "Smile.002")
        poses[1].name = ""
        self.assertEqual(poses[1].name, "Pose")
        poses[1].name = poses[2].name = "\N{SNOWMAN}" * 40  # three bytes each: Blender cuts it
        self.assertNotEqual(poses[1].name, poses[2].name)

    def test_replacing_keeps_name_and_place(self):
        obj = posable()
        self.api.store_pose(obj, "A")
        self.api.store_pose(obj, "B")
        bend(obj)
        self.api.store_pose(obj, "A", replace=True)
        self.assertEqual([pose.name for pose in obj.arap.poses], ["A", "B"])
        stored = places(obj)
        self.api.apply_pose(obj, "B")
        self.assertGreater(np.abs(places(obj) - stored).max(), 0.1)
        self.api.apply_pose(obj, "A")
        self.assert_close(places(obj), stored, 1e-5)

    def test_deleting(self):
        obj = posable()
        for name in "ABC":
            self.api.store_pose(obj, name)
        self.api.delete_pose(obj, "B")
        self.assertEqual([pose.name for pose in obj.arap.poses], ["A", "C"])
        self.assertEqual(obj.arap.active_pose_index, 1)
        message = "'Tube' has no stored pose 'B': choose one of the list"
        for function in (self.api.delete_pose, self.api.apply_pose, self.api.mirror_pose):
            self.assert_error(ValueError, message, function, obj, "B")

    def test_refusals(self):
        obj = mesh_object()
        message = "'Tube' has no handle that works: add one, or repair the ones it has"
        self.assert_error(ValueError, message, self.api.store_pose, obj)
        message = "The pose needs a name: type one, for example Smile"
        self.assert_error(ValueError, message, self.api.store_pose, obj, "")

    def test_saved_with_the_file_and_copied_with_the_object(self):
        obj = posable()
        bend(obj)
        stored = module("scene.handle_motion").handle_matrices(obj)
        self.api.store_pose(obj, "Bent")
        self.api.reset_handles(obj)
        obj = opened_again()
        copy = copied(obj)
        self.api.copy_handles(copy)
        for one in (obj, copy):
            self.assertEqual(str(self.api.apply_pose(one, "Bent")), "")
            self.assert_close(module("scene.handle_motion").handle_matrices(one), stored, 1e-5)


class BlendTest(SceneTest):
    def test_half_of_a_swing_is_on_the_circle(self):
        """Two handles that turn together about a point turn together half as far: the mesh stays rigid."""
        obj = posable(matrix=PLACED)
        self.api.remove_control(obj, obj.arap.pins[0].name)
        self.api.add_handle(obj, BOTTOM, name="Foot")
        to_axis = Matrix.Translation((1.0, 0.0, 0.0))
        swing, half = (to_axis @ Matrix.Rotation(angle, 4, "Z") @ to_axis.inverted() for angle in (2.0, 1.0))
        rest = places(obj)
        for handle in obj.arap.handles:
            handle.target.matrix_world = swing @ handle.target.matrix_world
        bpy.context.view_layer.update()
        self.api.store_pose(obj, "Swung")
        self.assertEqual(str(self.api.blend_poses(obj, self.api.REST, "Swung", 0.5)), "")
        self.assert_close(places(obj), np.array(half) @ rest, 1e-5)
        stats = self.api.solve(obj)
        self.assertLess(stats.energy, 1e-6)

    def test_between_two_stored_poses_and_from_now(self):
        obj = posable()
        target = obj.arap.handles[0].target
        start = target.matrix_world.translation.copy()
        for name, x in (("Left", -1.0), ("Right", 2.0)):
            target.matrix_world.translation = start + Vector((x, 0.0, 0.0))
            bpy.context.view_layer.update()
            self.api.store_pose(obj, name)
        for factor, x in ((0.0, -1.0), (0.25, -0.25), (1.0, 2.0), (1.5, 3.5)):
            self.api.blend_poses(obj, "Left", "Right", factor)
            self.assertAlmostEqual(target.matrix_world.translation.x, start.x + x, delta=1e-5)
        self.api.blend_poses(obj, self.api.NOW, "Left", 0.5)
        self.assertAlmostEqual(target.matrix_world.translation.x, start.x + 1.25, delta=1e-5)
        self.api.blend_poses(obj, self.api.NOW, self.api.REST, 1.0)
        self.assertAlmostEqual(target.matrix_world.translation.x, start.x, delta=1e-5)

    def test_only_handles_that_both_know_are_moved(self):
        obj = posable()
        self.api.store_pose(obj, "Before")
        waist = obj.arap.controls[self.api.add_handle(obj, MIDDLE, name="Waist")]
        bend(obj)
        move(waist.target, (0.5, 0.0, 0.0))
        self.api.store_pose(obj, "After")
        there = places(obj)[1]
        placement = self.api.blend_poses(obj, "Before", "After", 0.5)
        self.assertEqual(placement.others, ("Waist",))
        self.assert_close(places(obj)[1], there, 0.0)

    def test_a_flat_pose_moves_nothing(self):
        obj = posable()
        target = obj.arap.handles[0].target
        target.scale.z = 0.0
        bpy.context.view_layer.update()
        self.api.store_pose(obj, "Flat")
        self.api.reset_handles(obj)
        before = places(obj)
        with self.assertRaisesRegex(ValueError, "^Handle 'Head' is flat or turned inside out"):
            self.api.blend_poses(obj, self.api.REST, "Flat", 0.5)
        self.assert_close(places(obj), before, 0.0)
        self.api.apply_pose(obj, "Flat")  # but the pose itself is there
        self.assertAlmostEqual(target.scale.z, 0.0, delta=1e-6)


class MirrorTest(SceneTest):
    def symmetric(self):
        """The tube lies along z; its quarter edges at +x and -x get a handle each."""
        obj = mesh_object(matrix=PLACED)
        self.api.add_pin(obj, BOTTOM)
        for name, column in (("Side.L", 0), ("Side.R", 4)):
            self.api.add_handle(obj, [12 * 8 + column, 13 * 8 + column], name=name)
        obj.arap.accuracy, obj.arap.max_iterations = 1e-7, 5000
        return obj

    def check_mirrored(self, obj):
        move(obj.arap.handles[0].target, (0.4, 0.3, 0.2), (0.2, 0.3, 0.4))
        self.api.solve(obj)
        shape = key_positions(obj)
        self.api.store_pose(obj, "Out.L")
        pose = self.api.mirror_pose(obj, "Out.L")
        self.assertEqual(pose.name, "Out.R")
        self.assertEqual([p.name for p in obj.arap.poses], ["Out.L", "Out.R"])
        self.assertEqual(str(self.api.apply_pose(obj, "Out.R")), "")
        self.api.solve(obj)
        image = shape * (-1.0, 1.0, 1.0)
        rest = rest_positions(obj)
        partner = np.linalg.norm(rest[:, None] * (-1.0, 1.0, 1.0) - rest[None], axis=2).argmin(axis=1)
        self.assert_close(key_positions(obj)[partner], image, 2e-3)
        self.assertGreater(np.abs(key_positions(obj) - shape).max(), 0.3)

    def test_by_name(self):
        self.check_mirrored(self.symmetric())

    def test_by_place_and_twice_is_the_pose_itself(self):
        obj = self.symmetric()
        for handle, name in zip(obj.arap.handles, ("One", "Two"), strict=True):
            handle.name = name
        move(obj.arap.handles[1].target, (0.4, 0.3, 0.2), (0.2, 0.3, 0.4))
        there = module("scene.handle_motion").handle_matrices(obj)
        self.api.store_pose(obj, "Out")
        self.assertEqual(self.api.mirror_pose(obj, "Out").name, "Out mirrored")
        self.api.mirror_pose(obj, "Out mirrored")
        self.api.reset_handles(obj)
        self.api.apply_pose(obj, "Out mirrored mirrored")
        self.assert_close(module("scene.handle_motion").handle_matrices(obj), there, 1e-5)

    def test_a_missing_partner_is_refused(self):
        obj = self.symmetric()
        self.api.store_pose(obj, "Out")
        self.api.remove_control(obj, obj.arap.handles[1].name)
        with self.assertRaisesRegex(ValueError, "^Handle 'Side.L' has no partner on the other side of X = 0"):
            self.api.mirror_pose(obj, "Out")
        self.api.mirror_pose(obj, "Out", 1)  # across Y it is its own
        self.api.remove_control(obj, obj.arap.handles[0].name)
        message = "All handles of pose 'Out' are gone: there is nothing to mirror"
        self.assert_error(ValueError, message, self.api.mirror_pose, obj, "Out")
        self.assertEqual(len(obj.arap.poses), 2)

    def test_what_has_no_partner_but_is_not_in_the_pose_does_not_matter(self):
        obj = self.symmetric()
        self.api.store_pose(obj, "Out")
        self.api.add_handle(obj, [40], name="Odd")
        self.assertEqual(len(self.api.mirror_pose(obj, "Out").motions), 2)


class OperatorTest(SceneTest):
    def setUp(self) -> None:
        super().setUp()
        self.obj = posable()
        bpy.context.view_layer.objects.active = self.obj

    def test_all_of_them(self):
        def call(operator, **arguments):
            self.assertEqual(getattr(bpy.ops.arap, operator)(**arguments), {"FINISHED"})

        def assert_shape(expected):
            self.assert_close(key_positions(self.obj), expected, 1e-4)

        bend(self.obj)
        self.api.solve(self.obj)
        bent, rest = key_positions(self.obj), rest_positions(self.obj)
        call("poses_store", name="Bent")
        self.api.reset_handles(self.obj)
        call("poses_apply")
        assert_shape(bent)
        call("poses_blend", start="REST", factor=0.0)
        assert_shape(rest)
        call("poses_store", is_replacing=True)
        call("poses_blend", start="NOW", pose="Bent", factor=1.0)
        assert_shape(rest)
        call("poses_blend", start="POSE", start_pose="Bent", pose="Bent", factor=0.3)
        call("poses_mirror", axis="Y")
        self.assertEqual(len(self.obj.arap.poses), 2)
        call("poses_to_keys")
        call("poses_delete")
        self.assertEqual([pose.name for pose in self.obj.arap.poses], ["Bent"])

    def test_errors_move_nothing(self):
        self.api.store_pose(self.obj, "Here")
        bend(self.obj)
        before = places(self.obj)
        self.obj.data.shape_keys or self.obj.shape_key_add(name="Basis")
        self.obj.data.shape_keys.use_relative = False
        with self.assertRaisesRegex(RuntimeError, "absolute"):
            bpy.ops.arap.poses_apply(pose="Here")
        self.assert_close(places(self.obj), before, 1e-6)

    def test_reasons(self):
        poses = module("poses.operators")
        context = bpy.context
        self.assertEqual(poses.why_not_storable(context), "")
        self.assertEqual(poses.why_no_stored_pose(context), "Store a pose first")
        self.api.store_pose(self.obj)
        self.assertEqual(poses.why_not_applicable(context), "")
        self.obj.arap.handles[0].is_enabled = False
        self.assertEqual(poses.why_not_applicable(context), "Add a handle first: nothing moves the mesh yet")
        self.obj.arap.handles[0].is_enabled = True
        job = module("poses.keys").PoseKeysJob(self.obj)
        self.assertEqual(poses.why_not_storable(context), "Wait for the mesh: shape keys are made of its poses")
        job.cancel()
        bpy.ops.object.mode_set(mode="EDIT")
        self.assertEqual(poses.why_not_storable(context), "Go to Object Mode first (Tab)")
        bpy.ops.object.mode_set(mode="OBJECT")
        self.api.remove_control(self.obj, self.obj.arap.handles[0].name)
        self.assertEqual(poses.why_not_storable(context), "Add a handle first: a pose stores the places of the handles")
