# SPDX-License-Identifier: GPL-3.0-or-later
"""The object-space rule: what a handle's place means, wherever object and handle stand and whatever moves them."""

import numpy as np
from looks import key_positions, rest_positions
from mathutils import Matrix
from support import SceneTest, bpy, module
from tubes import TOP, empty_at, move, posable

PLACED = Matrix.Translation((3.0, -2.0, 1.0)) @ Matrix.Rotation(0.7, 4, "Y") @ Matrix.Rotation(-0.4, 4, "X")


class SpaceTest(SceneTest):
    def test_object_and_handles_moved_together_change_nothing(self):
        """Even if the handle is no child of the object."""
        obj = posable()
        free = empty_at((0.0, 0.0, 4.0))
        obj.arap.handles[0].target = free
        move(free, (0.0, 0.8, -0.3), (-0.5, 0.0, 0.0))
        self.api.solve(obj)
        posed = key_positions(obj)
        obj.matrix_world = PLACED @ obj.matrix_world
        free.matrix_world = PLACED @ free.matrix_world
        bpy.context.view_layer.update()
        self.assert_close(module("scene.handle_motion").handle_matrices(obj)[0], np.eye(4), 1e-6)
        self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, 2e-4)

    def test_parent_constraint_driver_and_animation_move_a_handle(self):
        obj = posable()
        parent = empty_at((0.0, 0.0, 0.0))

        def parented(target):
            target.parent = parent
            parent.location.y = 0.5

        def constrained(target):
            target.constraints.new("COPY_LOCATION").target = parent
            parent.location = (0.0, 0.5, 4.0)

        def driven(target):
            target.driver_add("location", 1).driver.expression = "0.5"

        def animated(target):
            target.location.y = 0.5
            target.keyframe_insert("location", frame=10)
            self.scene.frame_set(10)

        for way in (parented, constrained, driven, animated):
            with self.subTest(way.__name__):
                target = empty_at((0.0, 0.0, 4.0))
                self.api.reset_pose(obj)
                obj.arap.handles[0].target = target
                before = np.array(target.matrix_world)
                way(target)
                bpy.context.view_layer.update()
                self.assertGreater(np.abs(np.array(target.matrix_world) - before).max(), 0.4)
                self.api.solve(obj)
                expected = rest_positions(obj)[TOP] + np.array([0.0, 0.5, 0.0])
                self.assert_close(key_positions(obj)[TOP], expected, 1e-5)
                parent.location = (0.0, 0.0, 0.0)

    def test_hidden_handles_work(self):
        obj = posable()
        target = obj.arap.handles[0].target
        target.hide_set(True)
        target.location.y += 0.5
        self.api.solve(obj)
        self.assert_close(key_positions(obj)[TOP], rest_positions(obj)[TOP] + np.array([0.0, 0.5, 0.0]))

    def test_an_object_scaled_to_nothing_is_refused(self):
        obj = posable()
        obj.scale.y = 0.0
        message = "'Tube' is scaled to nothing along an axis: give it a scale"
        self.assert_error(ValueError, message, self.api.solve, obj)
        self.assert_error(ValueError, message, self.api.add_handle, obj, TOP)
