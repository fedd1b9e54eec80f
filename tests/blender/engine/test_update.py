# SPDX-License-Identifier: GPL-3.0-or-later
"""Bound sessions: small updates, what ends them, and what goes on."""

import numpy as np
from looks import key_positions, rest_positions, unfit
from support import SceneTest, bpy, module, uid
from tubes import MIDDLE, TOP, bend, mesh_object, move, posable, solved


class FollowTest(SceneTest):
    def test_updates_reach_what_a_solve_reaches(self):
        obj, other = posable(), posable("Other")
        for item in (obj, other):
            bend(item)
        module("engine.update").prepare_session(obj)
        obj.arap.iterations_per_update = 7
        first = module("engine.update").update_pose(obj)
        self.assertEqual((first.iterations, first.stop_reason), (7, "max_iterations"))
        for _ in range(1000):
            last = module("engine.update").update_pose(obj)
            if last.stop_reason == "converged":
                break
        self.assertEqual(last.stop_reason, "converged")
        self.assertEqual(module("core.sessions").stats(obj.session_uid), last)
        self.api.solve(other)
        self.assert_close(key_positions(obj), key_positions(other), 2e-3)

    def test_the_time_limit_and_the_guess_can_be_given(self):
        obj = posable()
        bend(obj)
        module("engine.update").prepare_session(obj)
        done = module("engine.update").update_pose(
            obj, iterations=50, initial_guess="handle_rotations", time_limit_s=1e-9
        )
        self.assertEqual((done.iterations, done.stop_reason), (1, "time_limit"))

    def test_a_session_starts_from_the_pose_shown(self):
        obj = solved()
        posed = key_positions(obj)
        module("core.sessions").drop(obj.session_uid)
        session = module("engine.update").prepare_session(obj)
        self.assert_close(session.positions, posed, 1e-6)

    def test_settings_that_need_no_bind_take_effect_at_once(self):
        obj = posable()
        bend(obj)
        session = module("engine.update").prepare_session(obj)
        obj.arap.iterations_per_update = 3
        self.assertEqual(module("engine.update").update_pose(obj).iterations, 3)
        obj.arap.accuracy = 0.1
        self.assertEqual(module("engine.update").update_pose(obj).stop_reason, "converged")
        self.assertIs(module("engine.update").prepare_session(obj), session)

    def check_ended(self, obj, reason, *, is_thorough=False):
        self.assertEqual(unfit(obj, is_thorough=is_thorough), reason)
        before = key_positions(obj) if obj.data.shape_keys else None
        if not is_thorough:
            self.assert_error(RuntimeError, f"{reason}: start posing again", module("engine.update").update_pose, obj)
            self.assertEqual(unfit(obj), f"'{obj.name}' is not being posed")
            if before is not None:
                self.assert_close(key_positions(obj), before, 0.0)
        module("engine.update").prepare_session(obj)
        self.assertEqual(unfit(obj, is_thorough=True), "")

    def test_without_a_session(self):
        obj = posable()
        message = "'Tube' is not being posed: start posing again"
        self.assert_error(RuntimeError, message, module("engine.update").update_pose, obj)

    def test_changed_topology_ends_a_session_and_writes_nothing(self):
        obj = solved()
        n, faces = len(obj.data.vertices), len(obj.data.polygons)
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.mesh.subdivide()
        self.assertEqual(unfit(obj), "'Tube' is in Edit Mode: go back to Object Mode first")
        bpy.ops.object.mode_set(mode="OBJECT")
        now = len(obj.data.vertices), len(obj.data.polygons)
        self.check_ended(
            obj, f"The mesh of 'Tube' has changed ({n} vertices and {faces} faces, now {now[0]} and {now[1]})"
        )
        self.api.solve(obj)

    def test_changes_that_only_a_thorough_look_sees(self):
        for change, what in (
            (lambda obj: obj.data.flip_normals(), "faces of 'Tube' have"),
            (lambda obj: setattr(obj.data.vertices[5].co, "x", 2.0), "rest shape of 'Tube' has"),
            (lambda obj: obj.vertex_groups["Head"].add([TOP[0]], 0.5, "REPLACE"), "pins or handles of 'Tube' have"),
            (lambda obj: obj.vertex_groups["Stiff"].add(MIDDLE, 0.5, "REPLACE"), "stiffness of 'Tube' has"),
        ):
            with self.subTest(what):
                self.setUp()
                obj = posable()
                obj.vertex_groups.new(name="Stiff")
                self.api.add_stiffness_group(obj, "Stiff")
                module("engine.update").prepare_session(obj)
                change(obj)
                self.assertEqual(unfit(obj), "")
                self.check_ended(obj, f"The {what} changed", is_thorough=True)

    def test_changed_groups_settings_and_scale_end_a_session(self):
        obj = posable()
        module("engine.update").prepare_session(obj)
        obj.arap.pins[0].is_enabled = False
        self.check_ended(obj, "The pins or handles of 'Tube' have changed")
        obj.arap.energy = "spokes"
        self.check_ended(
            obj,
            "Model, cube size, Keep Volume, bending, rigidity, weights, threads, "
            "Weld Seams or Loose Pieces Follow of 'Tube' have changed",
        )
        self.api.add_stiffness_group(obj, "Head")
        self.check_ended(obj, "The stiffness of 'Tube' has changed")
        obj.scale.x = 2.0
        bpy.context.view_layer.update()
        self.check_ended(obj, "The scale of 'Tube' has changed")

    def test_turning_the_object_ends_nothing(self):
        obj = posable()
        session = module("engine.update").prepare_session(obj)
        for turn in (0.3, 1.0, 2.5):
            obj.rotation_euler = (turn, 0.5 * turn, -turn)
            bpy.context.view_layer.update()
            self.assertEqual(unfit(obj, is_thorough=True), "")
            self.assertIs(module("engine.update").prepare_session(obj), session)

    def test_a_session_of_another_mesh_is_not_adopted(self):
        obj = posable()
        session = module("engine.update").prepare_session(obj)
        inputs = module("core.sessions").get(uid("Tube")).inputs
        obj.data.vertices.add(1)
        n, faces = len(obj.data.vertices), len(obj.data.polygons)
        message = (
            f"The mesh of 'Tube' has changed ({n - 1} vertices and {faces} faces, now {n} and {faces}) "
            "while it was being prepared: start again"
        )
        self.assert_error(RuntimeError, message, module("engine.mesh").adopt, obj, inputs, session)

    def test_sync_goes_on_from_what_the_key_shows(self):
        """As after an undo: the data is another, the names are the same."""
        obj = solved()
        session = module("engine.update").prepare_session(obj)
        key = obj.data.shape_keys.key_blocks["ARAP"]
        key.data.foreach_set("co", rest_positions(obj).astype(np.float32).ravel())
        module("engine.mesh").sync(obj)
        self.assert_close(session.positions, rest_positions(obj), 1e-6)
        obj.shape_key_remove(key)
        module("engine.mesh").sync(obj)
        self.assert_close(session.positions, rest_positions(obj), 1e-6)
        module("engine.mesh").sync(mesh_object("Other"))

    def test_a_file_load_forgets_sessions_and_readouts(self):
        obj = posable()
        self.api.solve(obj)
        former = obj.session_uid
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        self.assertIsNone(module("core.sessions").stats(former))
        self.assertIsNone(module("core.sessions").get(former))

    def test_a_new_object_has_nothing_of_one_that_had_its_name(self):
        sessions = module("core.sessions")
        for leave, is_kept in ((bpy.data.objects.remove, False), (lambda obj: setattr(obj, "name", "Body"), True)):
            obj = posable()
            self.api.solve(obj)
            former = obj.session_uid
            self.assertIsNotNone(sessions.stats(former))
            leave(obj)
            bpy.context.view_layer.update()
            self.assertEqual([sessions.get(former) is not None, sessions.stats(former) is not None], [is_kept] * 2)
            obj = mesh_object()
            self.assertEqual(obj.name, "Tube")
            self.assertIsNone(module("core.sessions").stats(obj.session_uid))
            self.assertIsNone(module("core.sessions").get(uid("Tube")))
            bpy.data.objects.remove(obj)

    def test_cancelled_solves_and_binds_change_nothing(self):
        obj = posable()
        bend(obj)
        for text in ("Binding was cancelled; nothing has changed", "Solving was cancelled; the pose is as it was"):
            self.assert_error(self.api.Cancelled, text, self.api.solve, obj, progress=lambda _: False)
            self.assertIsNone(obj.data.shape_keys)
            module("engine.update").prepare_session(obj)
        self.api.solve(obj)
        posed = key_positions(obj)
        move(obj.arap.handles[0].target, (0.0, 1.0, 0.0))
        self.assert_error(
            self.api.Cancelled,
            "Solving was cancelled; the pose is as it was",
            self.api.solve,
            obj,
            progress=lambda _: False,
        )
        self.assert_close(key_positions(obj), posed, 0.0)
        self.assert_close(module("engine.update").prepare_session(obj).positions, posed, 1e-6)

    def test_later_rooms_are_told_of_each_pose(self):
        obj = posable()
        told = []

        def written(obj, key, positions, is_frame):
            self.assert_close(positions, key_positions(obj), 0.0)
            told.append((obj, key.name, is_frame))

        hook = module("props.hooks").key_written
        hook.append(written)
        self.addCleanup(hook.remove, written)
        self.api.solve(obj)
        module("engine.update").update_pose(obj)
        self.assertEqual(told, [(obj, "ARAP", False), (obj, "ARAP", True)])

    def test_progress_grows_from_bind_to_end(self):
        obj = posable()
        bend(obj)
        fractions = []
        self.api.solve(obj, progress=fractions.append)
        self.assertEqual(fractions, sorted(fractions))
        self.assertLess(fractions[0], 0.2)
        self.assertLessEqual(fractions[-1], 1.0)
