# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotation nodes in Blender: Rigidity, its stats, point handles and Exact, for posing, bakes and the command line."""

from __future__ import annotations

import numpy as np
from looks import in_world, key_positions, rest_positions, unfit
from mathutils import Matrix
from support import SceneTest, bpy, module, opened_again
from tubes import PLACED, move, posable

SIDE = 41  # vertices along an edge of the sheet, which is 2 wide
CENTRE = SIDE * SIDE // 2
STAYS = 1e-4 * 2.0 * 2.0**0.5
LARGEST = 5.0  # percent; the edges of the sheet are 1.8 percent of its diagonal


def sheet(matrix: Matrix | None = None) -> bpy.types.Object:
    """A square sheet, its rim pinned, Rigidity a few edges."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=SIDE - 1, y_subdivisions=SIDE - 1)
    obj = bpy.context.object
    obj.name = "Sheet"
    if len(obj.data.vertices) != SIDE * SIDE:
        raise AssertionError(f"the grid has {len(obj.data.vertices)} vertices")
    if matrix is not None:
        obj.matrix_world = matrix
    rim = np.flatnonzero(np.abs(rest_positions(obj)[:, :2]).max(axis=1) > 0.99)
    module("api").add_pin(obj, rim, name="Rim")
    obj.arap.rigidity = LARGEST
    obj.arap.accuracy = 1e-6
    obj.arap.max_iterations = 2000
    bpy.context.view_layer.update()
    return obj


def patch_of(obj: bpy.types.Object, index: int = 1):
    """What the live session holds for the handle of that index; pins come first."""
    patches = module("core.sessions").get(obj.session_uid).session.patches.get(index)
    return patches[0] if patches else None


def average(patch, positions: np.ndarray) -> np.ndarray:
    return patch.weights @ positions[patch.vertices]


class RigidityTest(SceneTest):
    def test_settings_have_their_defaults_and_survive_a_save(self):
        obj = posable()
        settings = module("scene.snapshot").settings_of(obj)
        self.assertEqual((settings.energy, settings.rigidity_radius), ("rotation_nodes", 0.02))
        numbers = {item.identifier: item.value for item in obj.arap.bl_rna.properties["energy"].enum_items}
        self.assertEqual(numbers, {"spokes_and_rims": 0, "spokes": 1, "rotation_nodes": 2}, "files have the numbers")
        self.api.add_handle(obj, [7], name="Point", use_exact=True)
        obj.arap.energy, obj.arap.rigidity = "spokes", 3.5
        obj = opened_again()
        self.assertEqual((obj.arap.energy, obj.arap.rigidity), ("spokes", 3.5))
        self.assertEqual([handle.use_exact for handle in obj.arap.handles], [False, True])

    def test_the_size_for_the_readout_is_that_of_the_rest_shape_as_seen(self):
        obj = posable(matrix=PLACED)
        size = module("scene.ui_cache").diagonal
        depsgraph = bpy.context.evaluated_depsgraph_get()

        def check():
            bpy.context.view_layer.update()
            stretch = module("core.transforms").stretch_of(np.array(obj.matrix_world))
            expected = np.linalg.norm(np.ptp(rest_positions(obj) @ stretch.T, axis=0))
            self.assertAlmostEqual(size(obj, depsgraph), expected, delta=1e-4 * expected)
            return expected

        before = check()
        move(obj.arap.handles[0].target, (0.0, 0.0, 20.0))
        self.api.solve(obj)
        self.assertAlmostEqual(check(), before, delta=1e-5 * before)  # not that of the pose
        obj.scale = obj.scale * 3.0
        self.assertAlmostEqual(check(), 3.0 * before, delta=1e-4 * before)
        obj.scale = (1.0, 1.0, 1.0)
        check()
        for point in obj.data.shape_keys.reference_key.data:
            point.co.z *= 2.0
        obj.data.update_tag()
        check()

    def test_lengths_are_in_the_units_of_the_scene(self):
        text = module("scene.versions").length_text
        units = self.scene.unit_settings
        units.system, units.scale_length = "METRIC", 1.0
        self.assertEqual(text(self.scene, 0.085), "8.5 cm")
        units.scale_length = 0.01
        self.assertEqual(text(self.scene, 8.5), "8.5 cm")
        units.system, units.scale_length = "NONE", 1.0
        self.assertEqual(float(text(self.scene, 0.085)), 0.085)


class PointHandleTest(SceneTest):
    def test_a_point_is_a_patch_and_its_empty_stands_at_the_average(self):
        for matrix in (Matrix(), PLACED):
            with self.subTest(matrix):
                obj = sheet(matrix)
                handle = obj.arap.controls[self.api.add_handle(obj, [CENTRE + 1], name="Point")]
                bpy.context.view_layer.update()
                module("engine.update").prepare_session(obj)
                patch = patch_of(obj)
                self.assertGreater(len(patch.vertices), 20)
                self.assert_close(
                    handle.target.matrix_world.translation, in_world(obj, average(patch, rest_positions(obj))[None])[0]
                )

    def test_exact_and_classic_handles_stand_at_their_vertices(self):
        obj = sheet()
        place = in_world(obj, rest_positions(obj)[[SIDE + 1]])[0]
        for energy, use_exact in (("rotation_nodes", True), ("spokes", False)):
            obj.arap.energy = energy
            handle = obj.arap.controls[self.api.add_handle(obj, [SIDE + 1], use_exact=use_exact)]
            bpy.context.view_layer.update()
            self.assert_close(handle.target.matrix_world.translation, place)

    def test_a_patch_beside_the_pinned_rim_ends_there_and_the_empty_knows(self):
        obj = sheet()
        vertex = SIDE * (SIDE // 2) + 2
        handle = obj.arap.controls[self.api.add_handle(obj, [vertex], name="Point")]
        bpy.context.view_layer.update()
        module("engine.update").prepare_session(obj)
        patch = patch_of(obj)
        rim = np.flatnonzero(np.abs(rest_positions(obj)[:, :2]).max(axis=1) > 0.99)
        self.assertFalse(set(patch.vertices.tolist()) & set(rim.tolist()))
        self.assert_close(handle.target.matrix_world.translation, average(patch, rest_positions(obj)))

    def test_adding_a_point_to_a_posed_mesh_never_moves_it(self):
        for matrix in (Matrix(), PLACED):
            with self.subTest(matrix):
                obj = sheet(matrix)
                first = obj.arap.controls[self.api.add_handle(obj, [CENTRE - 8], name="First")]
                move(first.target, (0.1, 0.1, 0.3))
                self.api.solve(obj)
                posed = key_positions(obj)
                handle = obj.arap.controls[self.api.add_handle(obj, [CENTRE + 5], name="Second")]
                bpy.context.view_layer.update()
                self.api.solve(obj)
                shown = in_world(obj, average(patch_of(obj, 2), posed)[None])[0]
                self.assert_close(handle.target.matrix_world.translation, shown, 1e-4)
                self.assert_close(in_world(obj, key_positions(obj)), in_world(obj, posed), STAYS)

    def test_what_is_added_within_the_reach_of_a_posed_point_leaves_the_mesh_too(self):
        row = SIDE
        disc = [CENTRE + dx + row * dy for dx in range(-3, 4) for dy in range(4, 11)]
        for what, add in {
            "a point": lambda obj: self.api.add_handle(obj, [CENTRE + 2]),
            "a vertex": lambda obj: self.api.add_handle(obj, [CENTRE + row], use_exact=True),
            "a region": lambda obj: self.api.add_handle(obj, disc),
            "a pin": lambda obj: self.api.add_pin(obj, [CENTRE - 1, CENTRE - 2, CENTRE - 1 - row]),
            "its own vertex": lambda obj: self.api.add_pin(obj, [CENTRE]),
        }.items():
            for matrix in (Matrix(), PLACED):
                with self.subTest(what, matrix=matrix):
                    obj = sheet(matrix)
                    first = obj.arap.controls[self.api.add_handle(obj, [CENTRE], name="First")]
                    move(first.target, (0.1, 0.1, 0.3))
                    self.api.solve(obj)
                    posed = key_positions(obj)
                    add(obj)
                    bpy.context.view_layer.update()
                    self.api.solve(obj)
                    self.assert_close(key_positions(obj), posed, STAYS)
                    # A reset takes the mesh back to rest all the same.
                    self.api.reset_handles(obj)
                    bpy.context.view_layer.update()
                    self.api.solve(obj)
                    self.assert_close(key_positions(obj), rest_positions(obj), STAYS)

    def test_a_handle_made_before_keeps_its_motion(self):
        """From a file of the classics: nothing moves while it is at rest, and the average takes the motion it has."""
        obj = sheet()
        obj.arap.energy = "spokes_and_rims"
        handle = obj.arap.controls[self.api.add_handle(obj, [CENTRE + 3], name="Point")]
        rest_matrix = handle.rest.copy()
        bpy.context.view_layer.update()
        obj.arap.energy = "rotation_nodes"
        self.api.solve(obj)
        self.assert_close(key_positions(obj), rest_positions(obj), 4e-6)
        self.assertEqual(handle.rest, rest_matrix)
        move(handle.target, (0.0, 0.0, 0.25), (0.0, 0.0, 0.5))
        self.api.solve(obj)
        patch, motion = patch_of(obj), module("scene.handle_motion").handle_matrices(obj)[1]
        expected = motion[:3, :3] @ average(patch, rest_positions(obj)) + motion[:3, 3]
        self.assert_close(average(patch, key_positions(obj)), expected)

    def test_exact_is_noticed_at_once(self):
        obj = sheet()
        handle = obj.arap.controls[self.api.add_handle(obj, [CENTRE], name="Point")]
        module("engine.update").prepare_session(obj)
        handle.use_exact = True
        self.assertEqual(unfit(obj), "The pins or handles of 'Sheet' have changed")
        module("engine.update").prepare_session(obj)
        self.assertIsNone(patch_of(obj))

    def test_an_empty_group_may_be_chosen_on_a_posed_mesh_and_painted_later(self):
        obj = posable()
        move(obj.arap.handles[0].target, (0.0, 0.0, 1.0))
        self.api.solve(obj)
        obj.vertex_groups.new(name="Later")
        module("setup.pins").add_pin_group(obj, "Later")
        obj.arap.handles[0].vertex_group = "Later"
        self.assertNotEqual(obj.arap.handles[0].rest.determinant(), 0.0, "the handle can work when it is painted")
