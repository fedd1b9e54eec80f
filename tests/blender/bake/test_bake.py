# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking an animation: every baked frame shows exactly its pose, and nothing else changes."""

import numpy as np
from support import (
    BOTTOM,
    TOP,
    SceneTest,
    animate,
    bpy,
    data_of,
    empty_at,
    key_positions,
    mesh_object,
    module,
    posable,
    rest_positions,
    shown_positions,
)


class BakeTest(SceneTest):
    def test_every_baked_frame_shows_exactly_its_pose(self):
        obj = posable()
        animate(obj)
        names = self.api.bake_animation(obj, 1, 21, 5)
        self.assertEqual(names, ["ARAP_0001", "ARAP_0006", "ARAP_0011", "ARAP_0016", "ARAP_0021"])
        poses = [key_positions(obj, name) for name in names]
        for pose, frame in zip(poses, (1, 6, 11, 16, 21), strict=True):
            self.scene.frame_set(frame)
            self.assert_close(shown_positions(obj), pose, 1e-6)
            # The handle's own vertices tell the true place at that frame.
            motion = module("scene.handle_motion").handle_matrices(obj)[1]
            expected = rest_positions(obj)[TOP] @ motion[:3, :3].T + motion[:3, 3]
            self.assert_close(pose[TOP], expected, 1e-5)
        self.assertGreater(np.abs(poses[2] - poses[0]).max(), 1.0)

    def test_a_follower_gets_every_solved_shape(self):
        obj = posable()
        animate(obj)
        job, taken = module("bake.keys").begin_bake(obj, 1, 21, 10), []
        job.takers.append(lambda shape: taken.append(shape.copy()))
        names = module("core.job").run_job(job)
        self.assertEqual(len(taken), 3)
        for name, shape in zip(names, taken, strict=True):
            self.assert_close(key_positions(obj, name), shape, 0.0)

    def test_frames_in_between_blend_linearly_and_outside_the_ends_hold(self):
        obj = posable()
        animate(obj)
        names = self.api.bake_animation(obj, 1, 21, 10)
        first, second, third = (key_positions(obj, name) for name in names)
        for frame, expected in (
            (4, 0.7 * first + 0.3 * second),
            (16, 0.5 * second + 0.5 * third),
            (-5, first),
            (40, third),
        ):
            self.scene.frame_set(frame)
            self.assert_close(shown_positions(obj), expected, 1e-5)

    def test_each_frame_is_solved_to_the_end(self):
        """The first frame from rest, each other one from the one before: not the few iterations of a drag."""
        obj = posable()
        animate(obj)
        obj.arap.accuracy, obj.arap.max_iterations = 1e-7, 5000
        names = self.api.bake_animation(obj, 6, 11, 5)
        for name, frame in zip(names, (6, 11), strict=True):
            self.scene.frame_set(frame)
            other = mesh_object(f"At{frame}")
            self.api.add_pin(other, BOTTOM)
            self.api.add_handle(other, TOP)
            other.arap.handles[0].rest = obj.arap.handles[0].rest
            self.api.remove_handle(other, 0)
            handle = self.api.add_handle(other, TOP)
            handle.target.matrix_world = obj.arap.handles[0].target.matrix_world
            bpy.context.view_layer.update()
            other.arap.accuracy, other.arap.max_iterations = 1e-7, 5000
            self.api.solve(other)
            self.assert_close(key_positions(obj, name), key_positions(other), 2e-3)

    def test_the_same_file_gives_the_same_bake(self):
        obj = posable()
        animate(obj)
        names = self.api.bake_animation(obj, 1, 11, 5)
        first = [key_positions(obj, name) for name in names]
        self.scene.frame_set(17)
        names = self.api.bake_animation(obj, 1, 11, 5)
        for name, expected in zip(names, first, strict=True):
            self.assert_close(key_positions(obj, name), expected, 0.0)

    def test_the_last_frame_is_always_baked(self):
        frames = module("bake.keys").frames_of
        self.assertEqual(frames(1, 10, 4), [1, 5, 9, 10])
        self.assertEqual(frames(-3, 1, 2), [-3, -1, 1])
        self.assertEqual(frames(7, 7, 1), [7])

    def test_one_frame_and_negative_frames(self):
        obj = posable()
        animate(obj)
        self.assertEqual(self.api.bake_animation(obj, -2, -2), ["ARAP_-002"])
        self.scene.frame_set(15)
        self.assert_close(shown_positions(obj), key_positions(obj, "ARAP_-002"), 1e-6)
        self.api.bake_animation(obj, -1200, -1200)
        self.assertEqual([key.name for key in obj.data.shape_keys.key_blocks], ["Basis", "ARAP_-1200"])

    def test_a_bake_replaces_the_one_before_and_nothing_else(self):
        obj = posable()
        animate(obj)
        self.api.bake_animation(obj, 1, 21, 5)
        self.api.bake_animation(obj, 1, 5, 4, prefix="Walk ")
        kept = obj.shape_key_add(name="ARAP_mine")
        kept.value = 0.5
        kept.keyframe_insert("value", frame=3)
        names = self.api.bake_animation(obj, 3, 9, 3)
        keys = obj.data.shape_keys
        self.assertEqual(
            {key.name for key in keys.key_blocks},
            {"Basis", "ARAP_mine", "Walk 0001", "Walk 0005", *names},
        )
        fcurves = module("scene.fcurves").fcurves_of(keys)
        self.assertEqual(len(fcurves), len(names) + 3)

    def test_a_bake_that_was_pushed_to_the_nla_is_replaced(self):
        obj = posable()
        animate(obj)
        names = self.api.bake_animation(obj, 1, 21, 10)
        shown = {}
        for frame in (1, 6, 11, 21):
            self.scene.frame_set(frame)
            shown[frame] = shown_positions(obj)
        animation = obj.data.shape_keys.animation_data
        strip = animation.nla_tracks.new().strips.new("Bake", 1, animation.action)
        animation.action = None
        self.assertEqual(self.api.bake_animation(obj, 1, 21, 10), names)
        self.assertEqual([key.name for key in obj.data.shape_keys.key_blocks], ["Basis", *names])
        of_strip = list(module("scene.fcurves").all_fcurves_of(obj.data.shape_keys))[len(names) :]
        self.assertEqual(of_strip, [], "what moved keys that are gone is gone too")
        self.assertNotEqual(strip.action, animation.action)
        for frame, positions in shown.items():
            self.scene.frame_set(frame)
            self.assert_close(shown_positions(obj), positions, 1e-5)

    def test_a_key_that_no_bake_made_stays(self):
        obj = posable()
        animate(obj)
        self.scene.frame_set(11)
        self.api.solve(obj)
        self.api.bake_pose(obj, "ARAP_2024")
        posed = key_positions(obj, "ARAP_2024")
        self.api.bake_animation(obj, 1, 5, 4)
        names = self.api.bake_animation(obj, 3, 9, 3)
        self.assertEqual({key.name for key in obj.data.shape_keys.key_blocks}, {"Basis", "ARAP", "ARAP_2024", *names})
        self.assert_close(key_positions(obj, "ARAP_2024"), posed, 0.0)
        message = (
            "There is a shape key 'ARAP_2024' that no bake has made: rename it, or take another prefix (in the tab: "
            "another name in Settings > Shape Key)"
        )
        self.assert_error(ValueError, message, self.api.bake_animation, obj, 2020, 2030)

    def test_the_active_key_stays(self):
        obj = posable()
        animate(obj)
        self.api.bake_animation(obj, 1, 9, 4)
        keys = obj.data.shape_keys.key_blocks
        obj.shape_key_add(name="Smile").value = 0.0
        for name in ("Smile", "ARAP_0005", "Basis"):
            obj.active_shape_key_index = keys.find(name)
            self.api.bake_animation(obj, 1, 9, 4)
            self.assertEqual(obj.active_shape_key.name, name)

    def test_the_live_key_does_not_add_to_the_baked_ones(self):
        obj = posable()
        animate(obj)
        self.scene.frame_set(11)
        self.api.solve(obj)
        live = key_positions(obj)
        names = self.api.bake_animation(obj, 1, 21, 10)
        self.assertTrue(obj.data.shape_keys.key_blocks["ARAP"].mute)
        self.assert_close(key_positions(obj), live, 0.0)
        self.scene.frame_set(21)
        self.assert_close(shown_positions(obj), key_positions(obj, names[-1]), 1e-6)
        self.api.bake_animation(obj, 1, 21, 10)  # again, with the live key muted

    def test_other_keys_and_the_frame_stay(self):
        obj = posable()
        animate(obj)
        obj.shape_key_add(name="Basis")
        smile = obj.shape_key_add(name="Smile")
        for point in smile.data:
            point.co.x += 0.25
        smile.value = 1.0
        self.scene.frame_set(7, subframe=0.25)
        names = self.api.bake_animation(obj, 1, 21, 10)
        self.assertEqual((self.scene.frame_current, self.scene.frame_subframe), (7, 0.25))
        self.assertEqual(smile.value, 1.0)
        self.scene.frame_set(11)
        self.assert_close(shown_positions(obj), key_positions(obj, names[1]) + np.array([0.25, 0.0, 0.0]), 1e-5)

    def test_an_animated_scale_keeps_the_mesh_rigid_as_seen(self):
        """At each frame the bake is what a solve at that frame gives."""
        obj = posable()
        animate(obj)
        for frame, z in ((1, 1.0), (11, 2.0)):
            obj.scale.z = z
            obj.keyframe_insert("scale", frame=frame)
        obj.arap.accuracy, obj.arap.max_iterations = 1e-7, 5000
        names = self.api.bake_animation(obj, 1, 11, 10)
        baked = key_positions(obj, names[1])
        for name in names:
            obj.data.shape_keys.key_blocks[name].mute = True
        self.scene.frame_set(11)
        self.api.solve(obj)
        self.assert_close(baked, key_positions(obj), 2e-3)

    def test_estimate(self):
        obj = mesh_object()
        n = len(obj.data.vertices)
        estimate = module("bake.keys").estimate_bake(obj, 1, 48)
        self.assertEqual((estimate.n_keys, estimate.n_vertices), (48, n))
        self.assertEqual((estimate.bytes_in_file, estimate.bytes_in_memory), (48 * n * 12, 96 * n * 12))
        self.assertEqual(str(estimate), "48 keys, 78 kB in the file, 157 kB in memory")
        self.assertEqual(
            str(module("bake.keys").BakeEstimate(1, 1_000_000)), "1 key, 12 MB in the file, 24 MB in memory"
        )
        self.assertEqual(
            str(module("bake.keys").BakeEstimate(250, 1_000_000)), "250 keys, 3.0 GB in the file, 6.0 GB in memory"
        )
        self.assertEqual(str(module("bake.keys").BakeEstimate(2, 4)), "2 keys, 96 B in the file, 192 B in memory")


class CancelTest(SceneTest):
    def test_a_cancelled_bake_leaves_nothing(self):
        obj = posable()
        animate(obj)
        self.api.bake_animation(obj, 1, 5, 2)
        obj.data.shape_keys.key_blocks["ARAP_0003"].name = "Mine"
        before = data_of(obj)
        fractions = []

        def stop_half_way(fraction):
            fractions.append(fraction)
            return fraction < 0.5

        message = "The bake of 'Tube' was cancelled; nothing has changed"
        self.assert_error(self.api.Cancelled, message, self.api.bake_animation, obj, 1, 21, 2, stop_half_way)
        self.assertEqual(data_of(obj), before)
        self.assertGreaterEqual(fractions[-1], 0.5)
        self.assertLess(fractions[-1], 1.0)
        self.assertEqual(fractions, sorted(fractions))

    def test_moves_without_a_keyframe_survive_a_bake(self):
        obj = posable()
        animate(obj)
        target = obj.arap.handles[0].target
        self.scene.frame_set(3)
        target.location.x = 0.75
        before = target.matrix_basis.copy()
        stop = self.api.bake_animation, obj, 1, 21, 10, lambda _: False
        for _ in range(2):  # while it binds, then with the session that was made meanwhile
            self.assert_error(self.api.Cancelled, "The bake of 'Tube' was cancelled; nothing has changed", *stop)
            self.assertEqual(target.matrix_basis, before)
            module("follow.update").prepare_session(obj)
        self.api.bake_animation(obj, 1, 21, 10)
        self.assertEqual(target.matrix_basis, before)

    def test_changes_without_a_keyframe_of_anything_animated_survive_a_bake(self):
        """What a change of frame would overwrite: not only where the handle stands."""
        obj = posable()
        animate(obj)
        goal = empty_at((0.0, 0.0, 4.0), "Goal")
        obj.arap.handles[0].target.constraints.new("COPY_LOCATION").target = goal
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
        goal.animation_data_create().nla_tracks.new().strips.new("Strip", 1, self.swinging())
        animated = [
            (goal, "location", (1.0, 2.0, 3.0)),
            (goal, "hide_render", True),
            (goal, '["swing"]', 0.75),
            (goal, '["sway \\"a\\""]', [3.0, 4.0]),
            (rig.pose.bones["Bone"], "rotation_quaternion", (0.5, 0.5, 0.5, 0.5)),
            (material.node_tree, f'nodes["{shader.name}"].inputs[0].default_value', (0.0, 1.0, 0.0, 1.0)),
            (smile, "value", 0.25),
            (self.scene.view_settings, "exposure", 1.5),
        ]
        for item, path, _ in animated:
            item.keyframe_insert(path, frame=1)
        self.scene.frame_set(3)

        def change(item, path, value):
            name = path[2:-2].replace("\\", "")
            if path.startswith("["):
                item[name] = value
            elif path.endswith("default_value"):
                shader.inputs[0].default_value = value
            else:
                setattr(item, path, value)

        def now():
            values = [item.path_resolve(path) for item, path, _ in animated]
            values.append(goal.rotation_euler.x)
            return [tuple(value) if hasattr(value, "__len__") else value for value in values]

        before = now()
        for item, path, value in animated:
            change(item, path, value)
        goal.rotation_euler.x = 0.3
        changed = now()
        self.assertFalse([i for i, (a, b) in enumerate(zip(before, changed, strict=True)) if a == b])
        stop = self.api.bake_animation, obj, 1, 21, 10, lambda _: False
        self.assert_error(self.api.Cancelled, "The bake of 'Tube' was cancelled; nothing has changed", *stop)
        self.assertEqual(now(), changed)
        for _ in range(2):
            names = self.api.bake_animation(obj, 1, 21, 10)
            self.assertEqual(now(), changed)
        # The keys of the bake itself are as animated, though those of the former one had other values.
        self.assertEqual(round(obj.data.shape_keys.key_blocks[names[0]].value, 6), 0.8)
        self.api.bake_animation(obj, 1, 5, 4)
        self.assertEqual(round(obj.data.shape_keys.key_blocks[names[0]].value, 6), 0.5)
        bpy.data.objects.remove(rig)

    def swinging(self):
        """An action that turns an object."""
        other = empty_at((0.0, 0.0, 0.0), "Other")
        other.keyframe_insert("rotation_euler", index=0, frame=1)
        return other.animation_data.action

    def test_a_bake_that_fails_half_way_leaves_nothing(self):
        obj = posable()
        animate(obj)
        target = obj.arap.handles[0].target
        target.keyframe_insert("hide_viewport", frame=1)
        target.hide_viewport = True
        target.keyframe_insert("hide_viewport", frame=9)
        self.scene.frame_set(2)
        before = data_of(obj)
        with self.assertRaises(ValueError) as caught:
            self.api.bake_animation(obj, 1, 21, 4)
        self.assertIn("'Head' is disabled in viewports", str(caught.exception))
        self.assertEqual(data_of(obj), before)

    def test_a_job_binds_beside(self):
        """The bind runs in a thread of its own; a cancel drops it, and a step waits no longer than told."""
        obj = posable()
        animate(obj)
        job = module("bake.keys").begin_bake(obj, 1, 21, 10)
        self.assertIsNotNone(job.bind_fraction)
        job.cancel()
        self.assertIsNone(module("core.sessions").get("Tube"))
        job = module("bake.keys").begin_bake(obj, 1, 21, 10)
        while job.bind_fraction is not None:
            self.assertTrue(job.step())
        self.assertEqual(job.fraction, 0.0)
        job.cancel()
        again = module("bake.keys").begin_bake(obj, 1, 21, 10)
        self.assertIsNone(again.bind_fraction)
        again.cancel()
        obj.data.vertices[9].co.x = float("nan")
        job = module("bake.keys").begin_bake(obj, 1, 21, 10)
        with self.assertRaises(ValueError) as caught:
            while job.step():
                pass
        self.assertIn("9", str(caught.exception))
        job.cancel()

    def test_a_job_goes_in_steps(self):
        obj = posable()
        animate(obj)
        obj.arap.accuracy = 1e-9
        self.scene.frame_set(3)
        before = data_of(obj)
        job = module("bake.keys").begin_bake(obj, 1, 21, 10)
        steps = 0
        while job.step(time_limit_s=1e-6):
            steps += 1
            self.assertIn(job.frame, (1, 11, 21))
        self.assertGreater(steps, 20)  # many small steps for each frame
        self.assertEqual(job.fraction, 1.0)
        job.cancel()
        self.assertEqual(data_of(obj), before)
        whole = module("bake.keys").begin_bake(obj, 1, 21, 10)
        while whole.step(time_limit_s=60.0):
            pass
        for at_once, in_steps in zip(whole.readouts, job.readouts, strict=True):  # each step searches anew
            self.assertLessEqual(at_once.iterations, in_steps.iterations)
            self.assertAlmostEqual(at_once.energy, in_steps.energy, delta=1e-6 * in_steps.energy)
        self.assertEqual(whole.finish(), ["ARAP_0001", "ARAP_0011", "ARAP_0021"])

    def test_an_unfinished_job_writes_nothing(self):
        obj = posable()
        animate(obj)
        job = module("bake.keys").begin_bake(obj, 1, 21, 10)
        message = "The bake of 'Tube' is not done: call step() until it returns False"
        self.assert_error(RuntimeError, message, job.finish)
        job.cancel()

    def test_a_job_whose_object_or_mesh_goes_says_so(self):
        obj = posable()
        animate(obj)
        job = module("bake.keys").begin_bake(obj, 1, 21, 10)
        n = len(obj.data.vertices)
        obj.data.vertices.add(1)
        message = f"The mesh of 'Tube' has changed ({n} vertices, now {n + 1}): the bake has ended"
        self.assert_error(RuntimeError, message, job.step)
        bpy.data.objects.remove(obj)
        self.assert_error(RuntimeError, "'Tube' is not there any more: the bake has ended", job.step)
        self.scene.name = "Other"
        self.assert_error(RuntimeError, "Scene 'Scene' is not there any more: the bake has ended", job.step)
        job.cancel()

    def test_live_session_goes_on_where_it_was(self):
        obj = posable()
        animate(obj)
        self.scene.frame_set(11)
        self.api.solve(obj)
        session = module("follow.update").prepare_session(obj)
        before = session.positions.copy()
        self.api.bake_animation(obj, 1, 5, 2)
        self.assertIs(module("follow.update").prepare_session(obj), session)
        self.assert_close(session.positions, before, 0.0)


class RefusalTest(SceneTest):
    def test_arguments_are_checked(self):
        obj = posable()
        for function in (self.api.bake_animation, module("bake.keys").estimate_bake):
            self.assert_error(ValueError, "step = 0, must be 1 or more", function, obj, 1, 5, 0)
            self.assert_error(ValueError, "The last frame 1 is before the first, 5: swap them", function, obj, 5, 1)
        prefix = "x" * 60
        in_the_tab = "(in the tab: another name in Settings > Shape Key)"
        message = f"Prefix '{prefix}' is too long for the names of shape keys: take a shorter one {in_the_tab}"
        self.assert_error(ValueError, message, self.api.bake_animation, obj, 1, 2, prefix=prefix)
        obj.arap.key_name = "ARAP_0001"
        message = f"A bake with prefix 'ARAP_' would replace shape key 'ARAP_0001': take another prefix {in_the_tab}"
        self.assert_error(ValueError, message, self.api.bake_animation, obj, 1, 2, prefix="ARAP_")

    def test_objects_outside_the_scene_are_refused(self):
        obj = posable()
        other = bpy.data.scenes.new("Other")
        message = "'Tube' is not in scene 'Other': choose an object of it"
        self.assert_error(ValueError, message, self.api.bake_animation, obj, 1, 2, scene=other)
        message = "'Nothing' is not in scene 'Scene': choose an object of it"
        self.assert_error(ValueError, message, self.api.bake_animation, None, 1, 2)

    def test_another_scene_can_be_baked(self):
        obj = posable()
        animate(obj)
        other = bpy.data.scenes.new("Other")
        target = obj.arap.handles[0].target
        for item in (obj, target):
            other.collection.objects.link(item)
            self.scene.collection.objects.unlink(item)
        names = self.api.bake_animation(obj, 1, 11, 10, scene=other)
        self.assertGreater(np.abs(key_positions(obj, names[1]) - rest_positions(obj)).max(), 1.0)

    def test_linked_animation_of_the_keys_is_refused(self):
        import tempfile
        from pathlib import Path

        obj = posable()
        self.api.solve(obj)
        keys = obj.data.shape_keys
        key = obj.shape_key_add(name="Other")
        key.keyframe_insert("value", frame=1)
        action = keys.animation_data.action
        action.name = "Linked"
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "library.blend")
            bpy.data.libraries.write(path, {action})
            bpy.data.actions.remove(action)
            with bpy.data.libraries.load(path, link=True) as (_, data):
                data.actions = ["Linked"]
            keys.animation_data.action = bpy.data.actions["Linked"]
            message = (
                "The animation of the shape keys of 'Tube', action 'Linked', is linked from another file: "
                "make it local or take it off"
            )
            self.assert_error(ValueError, message, self.api.bake_animation, obj, 1, 2)

    def test_a_shared_action_of_the_keys_is_refused(self):
        obj = posable()
        animate(obj)
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
        self.assert_error(ValueError, message, self.api.bake_animation, obj, 1, 2)
        self.assertEqual(data_of(obj), before)
        animation.action = None
        self.api.bake_animation(obj, 1, 2)

    def test_absolute_keys_are_refused(self):
        obj = posable()
        obj.shape_key_add(name="Basis")
        obj.data.shape_keys.use_relative = False
        message = "The shape keys of 'Tube' are absolute: turn on Relative in the shape keys panel"
        self.assert_error(ValueError, message, self.api.bake_animation, obj, 1, 2)
