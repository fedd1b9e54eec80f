# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights of groups: soft and hard, several groups, stiffness and rigid regions."""

import numpy as np
from support import BOTTOM, MIDDLE, TOP, SceneTest, bend, bpy, key_positions, mesh_object, move, posable, rest_positions


class WeightTest(SceneTest):
    def test_a_soft_group_pulls_the_more_the_larger_its_weight(self):
        obj = posable()
        bend(obj)
        self.api.solve(obj)
        target = key_positions(obj)[TOP]
        distances = []
        for weight in (0.1, 0.5, 0.9, 1.0):
            obj.vertex_groups["Head"].add(TOP, weight, "REPLACE")
            self.api.solve(obj)
            distances.append(np.abs(key_positions(obj)[TOP] - target).max())
        self.assertEqual(distances, sorted(distances, reverse=True))
        self.assertGreater(distances[0], 0.02)
        self.assertLess(distances[-1], 1e-4)

    def test_weight_zero_is_free(self):
        obj = posable()
        self.api.add_pin(obj, MIDDLE, name="Waist")
        obj.vertex_groups["Waist"].add(MIDDLE, 0.0, "REPLACE")
        bend(obj)
        done = self.api.solve(obj)
        self.assertGreater(np.abs(key_positions(obj) - rest_positions(obj))[MIDDLE].max(), 0.05)
        self.assertEqual(done.free_vertices, done.vertices - len(BOTTOM) - len(TOP))

    def test_a_vertex_in_several_groups_takes_the_weighted_mean(self):
        obj = mesh_object()
        self.api.add_pin(obj, TOP, name="Still")
        handle = self.api.add_handle(obj, TOP, name="Moving")
        obj.vertex_groups["Still"].add(TOP, 0.25, "REPLACE")
        bpy.context.view_layer.update()
        move(handle.target, (0.0, 1.0, 0.0))
        done = self.api.solve(obj)
        self.assertEqual(done.free_vertices, done.vertices - len(TOP))
        # Largest strength 1: hard; mean of 0 at weight 1/4 and 1 at weight 1.
        self.assert_close(key_positions(obj)[TOP], rest_positions(obj)[TOP] + np.array([0.0, 0.8, 0.0]))

    def test_parts_that_nothing_holds_are_reported_and_stay(self):
        obj, other = posable(), mesh_object("Other")
        n = len(obj.data.vertices)
        other.data.transform(obj.matrix_world.Translation((3.0, 0.0, 0.0)))
        with bpy.context.temp_override(active_object=obj, selected_editable_objects=[obj, other]):
            bpy.ops.object.join()
        bpy.context.view_layer.update()
        bend(obj)
        done = self.api.solve(obj)
        self.assertEqual((done.vertices, done.parts_at_rest), (2 * n, 1))
        self.assert_close(key_positions(obj)[n:], rest_positions(obj)[n:], 4e-6)

    def test_a_rigid_group_moves_as_one_body(self):
        obj = posable()
        ring = [*MIDDLE, *range(MIDDLE[-1] + 1, MIDDLE[-1] + 17)]
        obj.vertex_groups.new(name="Bone").add(ring, 0.6, "REPLACE")
        bend(obj)

        def distances(positions):
            part = positions[ring]
            return np.linalg.norm(part[:, None] - part[None], axis=2)

        at_rest = distances(rest_positions(obj))
        self.api.solve(obj)
        self.assertGreater(np.abs(distances(key_positions(obj)) - at_rest).max(), 0.01)
        obj.arap.rigid_group = "Bone"
        self.api.solve(obj)
        self.assert_close(distances(key_positions(obj)), at_rest, 1e-5)
        self.assertGreater(np.abs(key_positions(obj) - rest_positions(obj))[ring].max(), 0.05)

    def test_a_stiff_group_bends_less(self):
        obj = posable()
        obj.vertex_groups.new(name="Stiff").add(MIDDLE, 1.0, "REPLACE")
        bend(obj)

        def out_of_shape():
            part = [positions[MIDDLE] for positions in (rest_positions(obj), key_positions(obj))]
            at_rest, now = (np.linalg.norm(p[:, None] - p[None], axis=2) for p in part)
            return np.abs(now - at_rest).max()

        for energy in ("rotation_nodes", "spokes_and_rims"):
            with self.subTest(energy):
                obj.arap.energy, obj.arap.stiffness_group = energy, ""
                self.api.solve(obj)
                soft = out_of_shape()
                obj.arap.stiffness_group = "Stiff"
                self.api.solve(obj)
                self.assertLess(out_of_shape(), 0.5 * soft)

    def test_groups_for_stiffness_and_rigidity_must_exist(self):
        obj = posable()
        for setting in ("stiffness_group", "rigid_group"):
            setattr(obj.arap, setting, "Tail")
            message = "'Tube' has no vertex group 'Tail' for stiffness or rigidity: choose another"
            self.assert_error(ValueError, message, self.api.solve, obj)
            setattr(obj.arap, setting, "")

    def test_a_group_without_weights_holds_nothing(self):
        obj = mesh_object()
        obj.vertex_groups.new(name="Empty")
        self.api.add_pin_group(obj, "Empty")
        message = "No vertex is pinned or has a handle: add a pin or a handle, or give its group weight"
        self.assert_error(ValueError, message, self.api.solve, obj)

    def test_a_handle_without_weights_is_told_before_it_is_solved(self):
        obj = posable()
        obj.vertex_groups.new(name="Empty")
        message = (
            "Handle 'Head' of 'Tube': vertex group 'Empty' has no weights; assign vertices to it or remove the handle"
        )

        def problem():
            bpy.context.view_layer.update()
            return self.api.handle_problem(obj, 0, with_weights=True)

        self.assertEqual(problem(), "")
        obj.arap.handles[0].vertex_group = "Empty"
        self.assertEqual(problem(), message)
        self.assert_error(ValueError, message, self.api.solve, obj)
        obj.vertex_groups["Empty"].add(TOP, 0.5, "REPLACE")
        self.assertEqual(problem(), "")
        obj.vertex_groups["Empty"].add(TOP, 0.0, "REPLACE")
        self.assertEqual(problem(), message)
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.mode_set(mode="EDIT")
        self.assertEqual(problem(), "", "not told while the mesh is being edited")
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assertEqual(problem(), message)
        obj.vertex_groups["Empty"].name = "Renamed"
        obj.arap.handles[0].vertex_group = "Renamed"
        self.assertEqual(problem(), message.replace("Empty", "Renamed"))

    def test_an_undo_brings_the_weights_back_for_the_panel_too(self):
        obj = posable()
        self.assertEqual(self.api.handle_problem(obj, 0, with_weights=True), "")
        bpy.ops.ed.undo_push(message="weights")
        obj.vertex_groups["Head"].remove(TOP)
        bpy.context.view_layer.update()
        self.assertIn("has no weights", self.api.handle_problem(obj, 0, with_weights=True))
        bpy.ops.ed.undo_push(message="none")
        bpy.ops.ed.undo()
        self.assertEqual(self.api.handle_problem(bpy.data.objects["Tube"], 0, with_weights=True), "")
