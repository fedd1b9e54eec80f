# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking an animation: every baked frame shows exactly its pose, and nothing else changes."""

import numpy as np
from looks import data_of, key_names, key_positions, rest_positions, shown_positions
from support import SceneTest, bpy, module, uid
from tubes import TOP, animated, armature, empty_at, mesh_object, own_key, posable

CANCELLED = "The bake of 'Tube' was cancelled; nothing has changed"
IN_THE_TAB = "(in the tab: Advanced > Shape Key)"


class BakeTest(SceneTest):
    def shown_at(self, frame, obj):
        self.scene.frame_set(frame)
        return shown_positions(obj)

    def test_every_baked_frame_shows_exactly_its_pose(self):
        obj = animated()
        names = self.api.bake_animation(obj, 1, 21, 5)
        self.assertEqual(names, ["ARAP_0001", "ARAP_0006", "ARAP_0011", "ARAP_0016", "ARAP_0021"])
        poses = [key_positions(obj, name) for name in names]
        for pose, frame in zip(poses, (1, 6, 11, 16, 21), strict=True):
            self.assert_close(self.shown_at(frame, obj), pose, 1e-6)
            # The vertices of the handle tell the true place at that frame.
            motion = module("scene.handle_motion").handle_matrices(obj)[1]
            self.assert_close(pose[TOP], rest_positions(obj)[TOP] @ motion[:3, :3].T + motion[:3, 3], 1e-5)
        self.assertGreater(np.abs(poses[2] - poses[0]).max(), 1.0)

    def test_a_follower_gets_every_solved_shape(self):
        obj = animated()
        job, taken = module("bake.keys").BakeJob(obj, 1, 21, 10), []
        job.takers.append(lambda shape: taken.append(shape.copy()))
        names = module("core.job").run_job(job)
        self.assertEqual(len(taken), 3)
        for name, shape in zip(names, taken, strict=True):
            self.assert_close(key_positions(obj, name), shape, 0.0)

    def test_frames_in_between_blend_linearly_and_outside_the_ends_hold(self):
        obj = animated()
        first, second, third = (key_positions(obj, name) for name in self.api.bake_animation(obj, 1, 21, 10))
        blends = ((4, 0.7 * first + 0.3 * second), (16, 0.5 * second + 0.5 * third), (-5, first), (40, third))
        for frame, expected in blends:
            self.assert_close(self.shown_at(frame, obj), expected, 1e-5)

    def test_the_same_file_gives_the_same_bake(self):
        obj = animated()
        first = [key_positions(obj, name) for name in self.api.bake_animation(obj, 1, 11, 5)]
        self.scene.frame_set(17)
        for name, expected in zip(self.api.bake_animation(obj, 1, 11, 5), first, strict=True):
            self.assert_close(key_positions(obj, name), expected, 0.0)

    def test_one_frame_and_negative_frames(self):
        obj = animated()
        self.assertEqual(self.api.bake_animation(obj, -2, -2), ["ARAP_-002"])
        self.assert_close(self.shown_at(15, obj), key_positions(obj, "ARAP_-002"), 1e-6)
        self.api.bake_animation(obj, -1200, -1200)
        self.assertEqual(key_names(obj), ["Basis", "ARAP_-1200"])

    def test_a_bake_replaces_the_one_before_and_nothing_else(self):
        obj = animated()
        self.api.bake_animation(obj, 1, 21, 5)
        self.api.bake_animation(obj, 1, 5, 4, prefix="Walk ")
        kept = obj.shape_key_add(name="ARAP_mine")
        kept.value = 0.5
        kept.keyframe_insert("value", frame=3)
        names = self.api.bake_animation(obj, 3, 9, 3)
        self.assertEqual(set(key_names(obj)), {"Basis", "ARAP_mine", "Walk 0001", "Walk 0005", *names})
        self.assertEqual(len(module("scene.fcurves").fcurves_of(obj.data.shape_keys)), len(names) + 3)

    def test_a_bake_that_was_pushed_to_the_nla_is_replaced(self):
        obj = animated()
        names = self.api.bake_animation(obj, 1, 21, 10)
        shown = {frame: self.shown_at(frame, obj) for frame in (1, 6, 11, 21)}
        animation = obj.data.shape_keys.animation_data
        strip = animation.nla_tracks.new().strips.new("Bake", 1, animation.action)
        animation.action = None
        self.assertEqual(self.api.bake_animation(obj, 1, 21, 10), names)
        self.assertEqual(key_names(obj), ["Basis", *names])
        of_strip = list(module("scene.fcurves").all_fcurves_of(obj.data.shape_keys))[len(names) :]
        self.assertEqual(of_strip, [], "the F-curves of removed keys are gone too")
        self.assertNotEqual(strip.action, animation.action)
        for frame, positions in shown.items():
            self.assert_close(self.shown_at(frame, obj), positions, 1e-5)

    def test_a_key_that_no_bake_made_stays(self):
        obj = animated()
        self.scene.frame_set(11)
        self.api.solve(obj)
        self.api.bake_pose(obj, "ARAP_2024")
        posed = key_positions(obj, "ARAP_2024")
        self.api.bake_animation(obj, 1, 5, 4)
        names = self.api.bake_animation(obj, 3, 9, 3)
        self.assertEqual(set(key_names(obj)), {"Basis", "ARAP", "ARAP_2024", *names})
        self.assert_close(key_positions(obj, "ARAP_2024"), posed, 0.0)
        message = f"No bake has made shape key 'ARAP_2024': rename it, or choose another prefix {IN_THE_TAB}"
        self.assert_error(ValueError, message, self.api.bake_animation, obj, 2020, 2030)

    def test_the_active_key_stays(self):
        obj = animated()
        self.api.bake_animation(obj, 1, 9, 4)
        obj.shape_key_add(name="Smile").value = 0.0
        for name in ("Smile", "ARAP_0005", "Basis"):
            obj.active_shape_key_index = key_names(obj).index(name)
            self.api.bake_animation(obj, 1, 9, 4)
            self.assertEqual(obj.active_shape_key.name, name)

    def test_the_pose_key_does_not_add_to_the_baked_ones(self):
        obj = animated()
        self.scene.frame_set(11)
        self.api.solve(obj)
        live = key_positions(obj)
        for _ in range(2):  # the second time with the pose key muted
            names = self.api.bake_animation(obj, 1, 21, 10)
        self.assertTrue(obj.data.shape_keys.key_blocks["ARAP"].mute)
        self.assert_close(key_positions(obj), live, 0.0)
        self.assert_close(self.shown_at(21, obj), key_positions(obj, names[-1]), 1e-6)

    def test_other_keys_and_the_frame_stay(self):
        obj = animated()
        smile = own_key(obj, "Smile")
        self.scene.frame_set(7, subframe=0.25)
        names = self.api.bake_animation(obj, 1, 21, 10)
        self.assertEqual((self.scene.frame_current, self.scene.frame_subframe), (7, 0.25))
        self.assertEqual(smile.value, 1.0)
        self.assert_close(self.shown_at(11, obj), np.add(key_positions(obj, names[1]), (0.25, 0.0, 0.0)), 1e-5)

    def test_each_frame_is_solved_to_the_end_also_under_an_animated_scale(self):
        """The first frame from rest, each other one from the one before: the result is that of a solve."""
        for scales in ((1.0, 1.0), (1.0, 2.0)):
            with self.subTest(scales=scales):
                self.setUp()
                obj = animated()
                for frame, z in zip((6, 11), scales, strict=True):
                    obj.scale.z = z
                    obj.keyframe_insert("scale", frame=frame)
                obj.arap.accuracy, obj.arap.max_iterations = 1e-7, 5000
                names = self.api.bake_animation(obj, 6, 11, 5)
                for name in names:
                    obj.data.shape_keys.key_blocks[name].mute = True
                for name, frame in zip(names, (6, 11), strict=True):
                    self.scene.frame_set(frame)
                    self.api.solve(obj)
                    self.assert_close(key_positions(obj, name), key_positions(obj), 2e-3)

    def test_another_scene_can_be_baked(self):
        obj = animated()
        other = bpy.data.scenes.new("Other")
        for item in (obj, obj.arap.handles[0].target):
            other.collection.objects.link(item)
            self.scene.collection.objects.unlink(item)
        names = self.api.bake_animation(obj, 1, 11, 10, scene=other)
        self.assertGreater(np.abs(key_positions(obj, names[1]) - rest_positions(obj)).max(), 1.0)


class EditAgainTest(SceneTest):
    """After a bake: back to the pose in one act, and to the bake with the next one."""

    def setUp(self):
        super().setUp()
        self.obj = animated()
        self.scene.frame_set(11)
        self.api.solve(self.obj)
        bpy.context.view_layer.objects.active = self.obj
        self.posed = shown_positions(self.obj)

    def assert_posable(self, expected):
        self.assertEqual([op.poll() for op in (bpy.ops.arap.solve, bpy.ops.arap.edit_again)], [expected, not expected])

    def test_edit_again_shows_the_pose_and_the_next_bake_replaces_the_former(self):
        obj = self.obj
        self.assert_posable(True)
        self.api.bake_animation(obj, 1, 21, 5)
        self.assert_posable(False)
        self.scene.frame_set(1)
        self.assertEqual(bpy.ops.arap.edit_again(), {"FINISHED"})
        self.assert_posable(True)
        self.assert_close(shown_positions(obj), self.posed, 1e-6)
        names = self.api.bake_animation(obj, 1, 21, 10)
        self.assertEqual(key_names(obj), ["Basis", "ARAP", *names])
        self.assertFalse(any(obj.data.shape_keys.key_blocks[name].mute for name in names))
        self.assert_posable(False)

    def test_a_bake_with_another_prefix_mutes_the_former(self):
        first = self.api.bake_animation(self.obj, 1, 21, 10, prefix="One_")
        self.scene.frame_set(21)
        shown = shown_positions(self.obj)
        self.api.bake_animation(self.obj, 1, 21, 10, prefix="Two_")
        self.scene.frame_set(21)
        self.assert_close(shown_positions(self.obj), shown)
        self.assertTrue(all(self.obj.data.shape_keys.key_blocks[name].mute for name in first))

    def test_edit_again_leads_back_after_the_keys_were_removed_by_hand(self):
        for name in self.api.bake_animation(self.obj, 1, 21, 10):
            self.obj.shape_key_remove(self.obj.data.shape_keys.key_blocks[name])
        self.assert_posable(False)
        bpy.ops.arap.edit_again()
        self.assert_posable(True)
        self.assert_close(shown_positions(self.obj), self.posed, 1e-6)

    def test_a_bake_can_be_removed(self):
        self.api.bake_animation(self.obj, 1, 21, 10, prefix="Shot_")
        bpy.ops.arap.edit_again(is_removing=True)
        self.assertEqual(key_names(self.obj), ["Basis", "ARAP"])
        self.assert_close(shown_positions(self.obj), self.posed, 1e-6)

    def test_all_bakes_are_removed_and_nothing_else(self):
        other = self.api.bake_pose(self.obj, name="Mine_0001").name
        for prefix in ("One_", "Two_", "One_", "Three_"):
            self.api.bake_animation(self.obj, 1, 21, 10, prefix=prefix)
        bpy.ops.arap.edit_again(is_removing=True)
        self.assertEqual(key_names(self.obj), ["Basis", "ARAP", other])
        self.assertEqual(len(self.obj.arap.former_bakes), 0)

    def test_a_bake_without_a_pose_leads_back_too(self):
        obj = mesh_object("New")
        self.api.add_handle(obj, TOP)
        bpy.context.view_layer.objects.active = obj
        self.api.bake_animation(obj, 1, 2)
        self.assert_posable(False)
        bpy.ops.arap.edit_again()
        self.assert_posable(True)

    def test_a_mesh_cache_is_switched_off_and_the_next_export_shows_it(self):
        path = self.new_folder() / "shot.mdd"
        for _ in range(2):
            self.api.export_mesh_cache(self.obj, path, 1, 3, add_modifier=True)
            (cache,) = self.obj.modifiers
            self.assertEqual((cache.show_viewport, cache.show_render), (True, True))
            self.assert_posable(False)
            cache.show_viewport = False  # off in viewports alone: the final render still plays it
            self.assert_posable(False)
            bpy.ops.arap.edit_again()
            self.assertEqual((cache.show_viewport, cache.show_render), (False, False))
            self.assert_posable(True)


class RangeTest(SceneTest):
    """The frames that the dialogs propose."""

    def setUp(self):
        super().setUp()
        self.obj = posable()
        self.empty = self.obj.arap.handles[0].target
        self.scene.frame_start, self.scene.frame_end = 1, 250

    def assert_range(self, start, end):
        self.assertEqual(module("bake.frame_range").proposed_range(self.obj, self.scene), (start, end))

    def key(self, item, *frames):
        for frame in frames:
            item.keyframe_insert("location", frame=frame)

    def test_of_the_keys_of_what_moves_the_handles(self):
        self.assert_range(1, 250)
        self.key(self.obj, 1, 500)
        self.assert_range(1, 250)
        self.key(self.empty, 7)
        self.assert_range(1, 250)
        self.key(self.empty, 20.5)
        self.assert_range(7, 21)
        rig = armature()
        self.empty.constraints.new("COPY_LOCATION").target = rig
        self.key(rig.pose.bones["Upper"], 30, 40)
        self.assert_range(7, 40)
        twin = rig.copy()
        twin.animation_data_clear()
        self.scene.collection.objects.link(twin)
        self.key(twin, 50)
        self.empty.constraints.new("ARMATURE").targets.new().target = twin
        self.assert_range(7, 50)

    def test_of_strips(self):
        self.key(self.empty, 7, 20)
        animation = self.empty.animation_data
        track = animation.nla_tracks.new()
        track.strips.new("Move", 100, animation.action)
        animation.action = None
        self.assert_range(100, 113)
        track.mute = True
        self.assert_range(1, 250)

    def test_of_the_scene_where_keys_do_not_say_when_it_ends(self):
        self.key(self.empty, 7, 20)
        curve = module("scene.fcurves").fcurves_of(self.empty)[0]
        cycles = curve.modifiers.new("CYCLES")
        self.assert_range(1, 250)
        curve.modifiers.remove(cycles)
        self.assert_range(7, 20)
        self.empty.driver_add("scale", 0)
        self.assert_range(1, 250)


class CancelTest(SceneTest):
    def test_a_cancelled_bake_leaves_nothing(self):
        obj = animated()
        self.api.bake_animation(obj, 1, 5, 2)
        obj.data.shape_keys.key_blocks["ARAP_0003"].name = "Mine"
        before = data_of(obj)
        fractions = []

        def stop_half_way(fraction):
            fractions.append(fraction)
            return fraction < 0.5

        self.assert_error(self.api.Cancelled, CANCELLED, self.api.bake_animation, obj, 1, 21, 2, stop_half_way)
        self.assertEqual(data_of(obj), before)
        self.assertTrue(0.5 <= fractions[-1] < 1.0)
        self.assertEqual(fractions, sorted(fractions))

    def test_changes_without_a_keyframe_of_anything_animated_survive_a_bake(self):
        """A change of frame would overwrite them: those of the handle and of everything else."""
        obj = animated()
        target = obj.arap.handles[0].target
        goal = empty_at((0.0, 0.0, 4.0), "Goal")
        target.constraints.new("COPY_LOCATION").target = goal
        goal["swing"], goal['sway "a"'] = 0.5, [1.0, 2.0]
        rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
        self.scene.collection.objects.link(rig)
        bpy.context.view_layer.objects.active = rig
        bpy.ops.object.mode_set(mode="EDIT")
        rig.data.edit_bones.new("Bone").tail = (0.0, 0.0, 1.0)
        bpy.ops.object.mode_set(mode="OBJECT")
        material = bpy.data.materials.new("Paint")
        material.use_nodes = True
        shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
        smile = obj.shape_key_add(name="Basis") and obj.shape_key_add(name="Smile")
        other = empty_at((0.0, 0.0, 0.0), "Other")
        other.keyframe_insert("rotation_euler", index=0, frame=1)
        goal.animation_data_create().nla_tracks.new().strips.new("Strip", 1, other.animation_data.action)
        animated_items = [
            (target, "location", (0.75, 2.0, 3.0)),
            (goal, "location", (1.0, 2.0, 3.0)),
            (goal, "hide_render", True),
            (goal, '["swing"]', 0.75),
            (goal, '["sway \\"a\\""]', [3.0, 4.0]),
            (rig.pose.bones["Bone"], "rotation_quaternion", (0.5, 0.5, 0.5, 0.5)),
            (material.node_tree, f'nodes["{shader.name}"].inputs[0].default_value', (0.0, 1.0, 0.0, 1.0)),
            (smile, "value", 0.25),
            (self.scene.view_settings, "exposure", 1.5),
        ]
        for item, path, _ in animated_items:
            item.keyframe_insert(path, frame=1)
        self.scene.frame_set(3)

        def change(item, path, value):
            if path.startswith("["):
                item[path[2:-2].replace("\\", "")] = value
            elif path.endswith("default_value"):
                shader.inputs[0].default_value = value
            else:
                setattr(item, path, value)

        def now():
            values = [item.path_resolve(path) for item, path, _ in animated_items]
            values.append(goal.rotation_euler.x)
            return [tuple(value) if hasattr(value, "__len__") else value for value in values]

        before = now()
        for item, path, value in animated_items:
            change(item, path, value)
        goal.rotation_euler.x = 0.3
        changed = now()
        self.assertFalse([i for i, (a, b) in enumerate(zip(before, changed, strict=True)) if a == b])
        for _ in range(2):  # while it binds, then with the session that was made meanwhile
            stop = self.api.bake_animation, obj, 1, 21, 10, lambda _: False
            self.assert_error(self.api.Cancelled, CANCELLED, *stop)
            self.assertEqual(now(), changed)
            module("engine.update").prepare_session(obj)
        for _ in range(2):
            names = self.api.bake_animation(obj, 1, 21, 10)
            self.assertEqual(now(), changed)
        # The keys of the bake itself are as animated, though those of the former one had other values.
        self.assertEqual(round(obj.data.shape_keys.key_blocks[names[0]].value, 6), 0.8)
        self.api.bake_animation(obj, 1, 5, 4)
        self.assertEqual(round(obj.data.shape_keys.key_blocks[names[0]].value, 6), 0.5)
        bpy.data.objects.remove(rig)

    def test_a_bake_that_fails_half_way_leaves_nothing(self):
        obj = animated()
        target = obj.arap.handles[0].target
        target.keyframe_insert("hide_viewport", frame=1)
        target.hide_viewport = True
        target.keyframe_insert("hide_viewport", frame=9)
        self.scene.frame_set(2)
        before = data_of(obj)
        with self.assertRaisesRegex(ValueError, "'Head' is disabled in viewports"):
            self.api.bake_animation(obj, 1, 21, 4)
        self.assertEqual(data_of(obj), before)

    def test_a_job_binds_first(self):
        """The bind runs in a thread; a cancel drops it, and its error ends the job. What it has bound it gives back."""
        obj = animated()
        job = module("bake.keys").BakeJob(obj, 1, 21, 10)
        job.step(1e-6)
        self.assertIsNotNone(job.bind_fraction)
        job.cancel()
        self.assertIsNone(module("core.sessions").get(uid("Tube")))
        job = module("bake.keys").BakeJob(obj, 1, 21, 10)
        self.assertTrue(job.step())
        while job.bind_fraction is not None:
            self.assertTrue(job.step())
        self.assertEqual(job.fraction, 0.0)
        job.cancel()
        self.assertIsNone(module("core.sessions").get(uid("Tube")))
        obj.data.vertices[9].co.x = float("nan")
        job = module("bake.keys").BakeJob(obj, 1, 21, 10)
        with self.assertRaisesRegex(ValueError, "9"):
            while job.step():
                pass
        job.cancel()

    def test_a_session_that_is_there_is_used_and_stays(self):
        obj = animated()
        self.api.solve(obj)
        job = module("bake.keys").BakeJob(obj, 1, 21, 10)
        job.step(1e-6)
        self.assertIsNone(job.bind_fraction)
        job.cancel()
        self.assertIsNotNone(module("core.sessions").get(uid("Tube")))

    def test_a_job_goes_in_steps(self):
        obj = animated()
        obj.arap.accuracy = 1e-9
        self.scene.frame_set(3)
        before = data_of(obj)
        job = module("bake.keys").BakeJob(obj, 1, 21, 10)
        steps = 0
        while job.step(time_limit_s=1e-6):
            steps += 1
            self.assertIn(job.frame, (1, 11, 21))
        self.assertGreater(steps, 20)  # many small steps for each frame
        self.assertEqual(job.fraction, 1.0)
        job.cancel()
        self.assertEqual(data_of(obj), before)
        whole = module("bake.keys").BakeJob(obj, 1, 21, 10)
        message = "The bake of 'Tube' is not done: call step() until it returns False"
        self.assert_error(RuntimeError, message, whole.finish)
        while whole.step(time_limit_s=60.0):
            pass
        for at_once, in_steps in zip(whole.all_stats, job.all_stats, strict=True):  # each step starts its search again
            self.assertLessEqual(at_once.iterations, in_steps.iterations)
            self.assertAlmostEqual(at_once.energy, in_steps.energy, delta=1e-6 * in_steps.energy + 1e-12)
        self.assertEqual(whole.finish(), ["ARAP_0001", "ARAP_0011", "ARAP_0021"])

    def test_a_job_whose_object_or_mesh_goes_says_so(self):
        obj = animated()
        job = module("bake.keys").BakeJob(obj, 1, 21, 10)
        obj.data.vertices.add(1)
        message = "The mesh of 'Tube' has changed (136 vertices, now 137): the bake has ended"
        self.assert_error(RuntimeError, message, job.step)
        bpy.data.objects.remove(obj)
        self.assert_error(RuntimeError, "'Tube' is gone: the bake has ended", job.step)
        bpy.data.scenes.new("Other")
        bpy.data.scenes.remove(self.scene)
        self.assert_error(RuntimeError, "Scene 'Scene' is gone: the bake has ended", job.step)
        job.cancel()

    def test_a_job_whose_object_and_scene_get_other_names_goes_on(self):
        obj = animated()
        job = module("bake.keys").BakeJob(obj, 1, 21, 10)
        obj.name, self.scene.name = "Pole", "Other"
        while job.step(time_limit_s=60.0):
            pass
        self.assertEqual(job.finish(), ["ARAP_0001", "ARAP_0011", "ARAP_0021"])

    def test_live_session_goes_on_where_it_was(self):
        obj = animated()
        prepare_session = module("engine.update").prepare_session
        self.scene.frame_set(11)
        self.api.solve(obj)
        session = prepare_session(obj)
        before = session.positions.copy()
        self.api.bake_animation(obj, 1, 5, 2)
        self.assertIs(prepare_session(obj), session)
        self.assert_close(session.positions, before, 0.0)


class RefusalTest(SceneTest):
    def assert_refused(self, message, *arguments, **keywords):
        self.assert_error(ValueError, message, self.api.bake_animation, *arguments, **keywords)

    def test_arguments_are_checked(self):
        obj = posable()
        for percent in (-1.0, 101.0, float("nan")):
            message = f"fewest_keys_percent = {percent}, must be between 0 and 100"
            self.assert_refused(message, obj, 1, 5, fewest_keys_percent=percent)
        self.assert_refused("step = 0, must be 1 or more", obj, 1, 5, 0)
        prefix = "x" * 60
        message = f"Prefix '{prefix}' is too long for the name of a shape key: choose a shorter one {IN_THE_TAB}"
        self.assert_refused(message, obj, 1, 2, prefix=prefix)
        obj.arap.key_name = "ARAP_0001"
        message = f"A bake with prefix 'ARAP_' would replace shape key 'ARAP_0001': choose another prefix {IN_THE_TAB}"
        self.assert_refused(message, obj, 1, 2, prefix="ARAP_")

    def test_objects_outside_the_scene_are_refused(self):
        other = bpy.data.scenes.new("Other")
        self.assert_refused("'Tube' is not in scene 'Other': choose one of its objects", posable(), 1, 2, scene=other)
        self.assert_refused("'Nothing' is not in scene 'Scene': choose one of its objects", None, 1, 2)

    def test_linked_animation_of_the_keys_is_refused(self):
        obj = posable()
        self.api.solve(obj)
        obj.shape_key_add(name="Other").keyframe_insert("value", frame=1)
        animation = obj.data.shape_keys.animation_data
        action = animation.action
        action.name = "Linked"
        path = str(self.new_folder() / "library.blend")
        bpy.data.libraries.write(path, {action})
        bpy.data.actions.remove(action)
        with bpy.data.libraries.load(path, link=True) as (_, data):
            data.actions = ["Linked"]
        animation.action = bpy.data.actions["Linked"]
        message = (
            "The animation of the shape keys of 'Tube', action 'Linked', is linked from another file: "
            "make it local or take it off"
        )
        self.assert_refused(message, obj, 1, 2)

    def test_a_shared_action_of_the_keys_is_refused(self):
        obj = animated()
        self.api.bake_animation(obj, 1, 5, 4)
        action = obj.data.shape_keys.animation_data.action
        action.name = "Shared"
        action.use_fake_user = True
        self.api.bake_animation(obj, 1, 5, 4)
        other = mesh_object("Other")
        other.shape_key_add(name="Basis")
        animation = other.data.shape_keys.animation_data_create()
        animation.action = action
        if hasattr(animation, "action_slot"):
            animation.action_slot = obj.data.shape_keys.animation_data.action_slot
        message = (
            "The animation of the shape keys of 'Tube', action 'Shared', moves other data too, which would change: "
            "make the action single-user"
        )
        before = data_of(obj)
        self.assert_refused(message, obj, 1, 2)
        self.assertEqual(data_of(obj), before)
        animation.action = None
        self.api.bake_animation(obj, 1, 2)
