# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve as a job in steps; jobs and scripts that want the same mesh."""

import numpy as np
from looks import key_positions, unfit
from support import FakeLock, SceneTest, bpy, module, uid
from tubes import mesh_object, move, posable


class SolveJobTest(SceneTest):
    def run_job(self, job):
        while job.step(0.01):
            pass
        return job.finish()

    def test_it_does_what_solve_does(self):
        obj, other = posable(), posable("Other")
        for each in (obj, other):
            move(each.arap.handles[0].target, (0.5, 0.2, -0.3), (0.4, 0.0, 0.0))
        stats = self.api.solve(obj)
        job = self.api.begin_solve(other)
        self.assertIn("preparing the mesh", job.status)
        self.assertEqual(module("core.sessions").locked_by(uid("Other")), "it is solved")
        done = self.run_job(job)
        self.assertEqual((done.iterations, done.stop_reason), (stats.iterations, "converged"))
        np.testing.assert_array_equal(key_positions(other), key_positions(obj))
        self.assertEqual(module("core.sessions").locked_by(uid("Other")), "")
        self.assertEqual(unfit(other, is_thorough=True), "")
        self.assertEqual(self.run_job(self.api.begin_solve(other)).iterations, stats.iterations, "bound already")

    def test_differences_of_the_scale_do_not_add_up(self):
        obj = posable()
        for _ in range(4):
            obj.scale.x *= 1 + 0.7e-5
            bpy.context.view_layer.update()
            self.run_job(self.api.begin_solve(obj))
        session = module("core.sessions").get(uid("Tube")).session
        np.testing.assert_allclose(session.stretch, np.diag(obj.scale), atol=1e-5)

    def test_cancelled_it_leaves_everything_and_the_bind(self):
        obj = posable()
        move(obj.arap.handles[0].target, (0.5, 0.2, -0.3))
        self.api.solve(obj)
        before, session = key_positions(obj), module("core.sessions").get(uid("Tube")).session
        move(obj.arap.handles[0].target, (0.5, 0.0, 0.0))
        for has_started in (False, True):
            job = self.api.begin_solve(obj)
            if has_started:
                job.step(0.0)
            job.cancel()
            np.testing.assert_array_equal(key_positions(obj), before)
            self.assertIs(module("core.sessions").get(uid("Tube")).session, session)
            self.assertEqual(module("core.sessions").locked_by(uid("Tube")), "")
        self.assertEqual(self.api.solve(obj).stop_reason, "converged")

    def test_what_happens_to_the_mesh_meanwhile_ends_it(self):
        obj = posable()
        job = self.api.begin_solve(obj)
        while job.step(0.01):
            pass
        obj.name = "Renamed"
        job.finish()
        self.assertFalse(module("core.sessions").locked_by(obj.session_uid))
        job = self.api.begin_solve(obj)
        while job.step(0.01):
            pass
        bpy.data.objects.remove(obj)
        self.assert_error(RuntimeError, "'Renamed' is gone: there is nothing to pose", job.finish)
        job.cancel()
        obj = posable()
        job = self.api.begin_solve(obj)
        while job.step(0.01):
            pass
        obj.data.vertices.add(1)
        with self.assertRaises(RuntimeError) as caught:
            job.finish()
        self.assertIn("while it was solved: solve again", str(caught.exception))
        job.cancel()
        self.assertIsNone(obj.data.shape_keys)

    def test_what_solve_refuses_it_refuses_too(self):
        obj = mesh_object()
        message = "Nothing holds or moves 'Tube': add a pin or a handle"
        self.assert_error(ValueError, message, self.api.begin_solve, obj)
        self.assertEqual(module("core.sessions").locked_by(uid("Tube")), "")


class WaitTest(SceneTest):
    def test_an_act_that_comes_second_waits(self):
        obj = posable()
        sessions = module("core.sessions")
        self.api.store_pose(obj, "Pose")
        act = FakeLock("it is posed")
        sessions.lock(obj, act)
        for begin in (
            lambda: self.api.begin_solve(obj),
            lambda: module("bake.keys").BakeJob(obj, 1, 2),
            lambda: module("poses.keys").PoseKeysJob(obj),
            lambda: module("bake.cache").MeshCacheJob(obj, "tube.mdd", 1, 2),
        ):
            self.assert_error(RuntimeError, "Wait for 'Tube': it is posed", begin)
        self.assertIs(sessions.locks[uid("Tube")], act)
        sessions.unlock(obj.session_uid, act)
        job = self.api.begin_solve(obj)
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        other = posable()
        sessions.lock(other, act)
        job.cancel()
        self.assertIs(sessions.locks[other.session_uid], act, "of another file")
        sessions.unlock(other.session_uid, act)

    def test_a_script_waits_for_a_job_and_does_not_disturb_it(self):
        obj = posable()
        move(obj.arap.handles[0].target, (0.5, 0.2, -0.3))
        self.api.solve(obj)
        self.api.store_pose(obj, "Pose")
        update, result = module("engine.update"), module("pose.result")
        shown, state = key_positions(obj), result.capture_state(obj)
        folder = self.new_folder()
        for doing, begin in (
            ("it is solved", lambda: self.api.begin_solve(obj)),
            ("it is baked", lambda: module("bake.keys").BakeJob(obj, 1, 2)),
            ("shape keys are made of its poses", lambda: module("poses.keys").PoseKeysJob(obj)),
            (
                "its frames are exported",
                lambda: module("bake.cache").MeshCacheJob(obj, f"{folder}/tube.mdd", 1, 2),
            ),
        ):
            job = begin()
            job.step(0.001)
            for act in (
                self.api.solve,
                update.prepare_session,
                update.update_pose,
                self.api.reset_pose,
                self.api.apply_pose_as_rest,
                lambda tube: result.restore_state(tube, state),
            ):
                self.assert_error(RuntimeError, f"Wait for 'Tube': {doing}", act, obj)
            while job.step():
                pass
            job.cancel()
            np.testing.assert_array_equal(key_positions(obj), shown)
        self.assertEqual(self.api.solve(obj).stop_reason, "converged")
