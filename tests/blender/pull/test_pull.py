# SPDX-License-Identifier: GPL-3.0-or-later
"""Pulling without a window: what is under a pixel, what a drag holds, temporary pins, and what is refused."""

from types import SimpleNamespace
from unittest import mock

import numpy as np
from mathutils import Matrix
from support import (
    BOTTOM,
    LENGTH,
    MIDDLE,
    SEGMENTS,
    TOP,
    SceneTest,
    bpy,
    key_positions,
    mesh_object,
    module,
    posable,
    rest_positions,
    shown_positions,
    unfit,
)

SIZE = (400, 300)


class PullTest(SceneTest):
    def setUp(self) -> None:
        super().setUp()
        self.seen_mesh = module("pull.seen_mesh")
        self.api_pull = module("pull.hold")
        self.pull_pins = module("pull.pins")
        self.grab_region = module("pull.region")
        self.seen_mesh.clear()

    def view(self):
        """From -y, x to the right and z up, 100 pixels a unit, the middle of the tube in the middle."""
        perspective = np.zeros((4, 4))
        perspective[0, 0], perspective[1, 2] = 2.0 * 100.0 / SIZE[0], 2.0 * 100.0 / SIZE[1]
        perspective[1, 3] = -perspective[1, 2] * LENGTH / 2.0
        perspective[2, 1] = 0.1
        perspective[3, 3] = 1.0
        return module("pull.view").View(perspective, SIZE)

    def pick(self, obj, pixel=(200.0, 150.0), radius_px=30.0):
        bpy.context.view_layer.update()
        return self.seen_mesh.pick(obj, bpy.context.evaluated_depsgraph_get(), self.view(), pixel, radius_px)

    def grab(self, vertices, reach=1.0):
        return self.grab_region.Grab(np.asarray(vertices, dtype=np.int32), reach)

    def pull(self, obj, grab, shift):
        """A whole drag, without a mouse."""
        begun = self.api_pull.begin_pull(obj, bpy.context.evaluated_depsgraph_get(), [grab])
        session = module("core.sessions").build(begun.inputs)
        module("follow.mesh").adopt(obj, begun.inputs, session)
        motion = np.eye(4)
        motion[:3, 3] = shift
        matrices = begun.matrices(motion, np.array(obj.matrix_world))
        for _ in range(300):
            frame = module("follow.frame").Frame(obj, bpy.context.evaluated_depsgraph_get(), holds=begun.holds)
            done = frame.solve(matrices, initial_guess="previous")
            if done.stop_reason == "converged":
                break
        self.pull_pins.add(obj, begun.grabs)
        bpy.context.view_layer.update()
        return begun


class PickTest(PullTest):
    def test_the_patch_is_what_lies_within_the_circle_on_the_near_side(self):
        pick = self.pick(mesh_object())
        self.assertAlmostEqual(pick.place[0], 0.0, places=5)
        self.assertLess(pick.place[1], -0.4)
        self.assertAlmostEqual(pick.place[2], 2.0, places=5)
        self.assertLess(pick.normal[1], -0.9)
        self.assertAlmostEqual(pick.radius, 0.3, places=6)
        positions = rest_positions(mesh_object("Other"))
        expected = np.flatnonzero(np.linalg.norm(positions - pick.place, axis=1) <= 0.3)
        np.testing.assert_array_equal(pick.vertices, expected)

    def test_beside_the_mesh_there_is_nothing(self):
        self.assertIsNone(self.pick(mesh_object(), (20.0, 150.0)))

    def test_a_moved_turned_and_scaled_object_is_found_where_it_is_seen(self):
        obj = mesh_object()
        obj.location = (1.0, 2.0, 0.5)
        obj.scale = (1.0, 0.5, 0.8)
        obj.rotation_euler = (0.0, 0.0, 0.3)
        pick = self.pick(obj, (300.0, 150.0))
        self.assertAlmostEqual(pick.place[0], 1.0, places=5)
        seen = self.seen_mesh.read(obj, bpy.context.evaluated_depsgraph_get()).positions
        world = np.array(obj.matrix_world)
        self.assert_close(seen, rest_positions(obj) @ world[:3, :3].T + world[:3, 3])
        distance = np.linalg.norm(seen - pick.place, axis=1)
        np.testing.assert_array_equal(pick.vertices, np.flatnonzero(distance <= pick.radius))

    def test_another_mesh_with_as_many_faces_is_read_anew(self):
        obj, turned = mesh_object(), mesh_object("Turned")
        turned.data.transform(Matrix.Diagonal((1.0, 1.0, -1.0, 1.0)))
        turned.data.flip_normals()  # another order of corners
        read = self.seen_mesh.read
        read(obj, bpy.context.evaluated_depsgraph_get())
        obj.data = turned.data
        bpy.context.view_layer.update()
        found, expected = (read(item, bpy.context.evaluated_depsgraph_get()).topology for item in (obj, turned))
        np.testing.assert_array_equal(found.corner_vertices, expected.corner_vertices)

    def test_what_was_under_the_mouse_is_forgotten_with_the_file(self):
        obj = mesh_object()
        pull_draw = module("pull.draw")
        pull_draw.hover(bpy.context, obj, self.view(), (SIZE[0] / 2, SIZE[1] / 2), 30.0)
        self.assertIsNotNone(pull_draw._hover)
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        self.assertIsNone(pull_draw._hover)

    def test_other_shape_keys_and_deforming_modifiers_count(self):
        obj = mesh_object()
        obj.shape_key_add(name="Basis", from_mix=False)
        key = obj.shape_key_add(name="Aside", from_mix=False)
        for point in key.data:
            point.co.x += 1.0
        key.value = 1.0
        obj.modifiers.new("Up", "DISPLACE").direction = "Z"
        obj.modifiers["Up"].mid_level = 0.5
        self.assertIsNone(self.pick(obj, (120.0, 150.0)))
        pick = self.pick(obj, (300.0, 150.0))
        self.assertAlmostEqual(pick.place[0], 1.0, places=5)
        self.assert_close(
            self.seen_mesh.read(obj, bpy.context.evaluated_depsgraph_get()).positions, shown_positions(obj)
        )

    def test_what_subdivision_makes_is_traced_back(self):
        obj = mesh_object()
        obj.modifiers.new("Subdivision", "SUBSURF").levels = 2
        pick = self.pick(obj)
        self.assertLess(int(pick.vertices.max()), SEGMENTS * 17)
        rest = rest_positions(obj)[pick.vertices]
        self.assertTrue((rest[:, 1] < 0.0).all())
        self.assertLess(np.abs(rest[:, 2] - 2.0).max(), 0.35)

    def test_the_image_of_a_mirror_modifier_is_refused(self):
        obj = mesh_object()
        obj.data.transform(__import__("mathutils").Matrix.Translation((1.2, 0.0, 0.0)))
        obj.modifiers.new("Mirror", "MIRROR")
        self.assertIsNotNone(self.pick(obj, (320.0, 150.0)))
        self.assert_error(
            ValueError,
            "This part of 'Tube' is made by a modifier: pull the mesh itself",
            self.pick,
            obj,
            (80.0, 150.0),
        )

    def test_what_cannot_be_traced_back_is_refused(self):
        obj = mesh_object()
        obj.modifiers.new("Bevel", "BEVEL").limit_method = "NONE"
        self.assert_error(
            ValueError,
            "What modifier 'Bevel' of 'Tube' makes cannot be traced back to the mesh: "
            "turn it off in the viewport to pull",
            self.pick,
            obj,
        )
        obj.modifiers["Bevel"].show_viewport = False
        bpy.context.view_layer.update()
        self.assertIsNotNone(self.pick(obj))

    def test_what_is_seen_is_read_again_after_a_change(self):
        obj = mesh_object()
        self.pick(obj)
        obj.location.x = 1.0
        bpy.context.view_layer.update()
        self.assertIsNone(self.pick(obj, (120.0, 150.0)))
        self.assertAlmostEqual(self.pick(obj, (300.0, 150.0)).place[0], 1.0, places=5)

    def test_a_pin_behind_the_viewer_hides_no_other_one(self):
        pull_draw = module("pull.draw")
        dots = np.array([[10.0, 20.0], [np.nan, np.nan], [30.0, 40.0]])
        with mock.patch.object(pull_draw.batches, "draw_pixels") as draw_pixels:
            pull_draw.draw_dots(dots, 5.0, (1.0, 1.0, 1.0, 1.0))
        kind, corners, _ = draw_pixels.call_args.args
        self.assertEqual(kind, "TRIS")
        self.assert_close(corners.reshape(2, -1, 3, 2)[:, :, 0], np.repeat(dots[[0, 2], None], 48, axis=1), 0.0)

    def test_nothing_is_drawn_of_a_mesh_that_the_view_hides(self):
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        bpy.context.view_layer.update()
        areas = (area for screen in bpy.data.screens for area in screen.areas if area.type == "VIEW_3D")
        space = next(areas).spaces.active
        space.overlay.show_overlays = True
        context = SimpleNamespace(
            space_data=space, object=obj, view_layer=bpy.context.view_layer, selected_objects=[obj]
        )
        drawn = module("ui.checks").find_drawn_object
        self.assertEqual(drawn(context), obj)
        obj.hide_set(True)
        bpy.context.view_layer.update()
        self.assertIsNone(drawn(context))
        obj.hide_set(False)
        bpy.context.view_layer.update()
        space.show_object_viewport_mesh = False
        self.assertIsNone(drawn(context))
        space.show_object_viewport_mesh = True
        space.overlay.show_overlays = False
        self.assertIsNone(drawn(context))
        space.overlay.show_overlays = True
        self.assertEqual(drawn(context), obj)

    def test_triangles_of_a_patch_cover_its_whole_faces(self):
        obj = mesh_object()
        seen = self.seen_mesh.read(obj, bpy.context.evaluated_depsgraph_get())
        ring = np.array([*MIDDLE, *(i + SEGMENTS for i in MIDDLE)], dtype=np.int32)
        triangles = self.seen_mesh.patch_triangles(seen, ring)
        self.assertEqual(triangles.shape, (2 * SEGMENTS, 3))
        self.assertEqual(
            self.seen_mesh.patch_triangles(seen, np.array(BOTTOM, dtype=np.int32)).shape, (SEGMENTS - 2, 3)
        )


class DragTest(PullTest):
    def test_the_rest_is_held_beyond_the_reach(self):
        obj = mesh_object()
        rest = rest_positions(obj)
        self.pull(obj, self.grab(MIDDLE), (0.3, 0.0, 0.0))
        posed = shown_positions(obj)
        self.assert_close(posed[MIDDLE], rest[MIDDLE] + (0.3, 0.0, 0.0), 1e-4)
        self.assert_close(posed[[*BOTTOM, *TOP]], rest[[*BOTTOM, *TOP]], 1e-5)
        self.assertEqual(obj.data.shape_keys.key_blocks["ARAP"].value, 1.0)

    def test_the_next_drag_begins_where_the_mesh_is_and_leaves_what_was_pulled(self):
        obj = mesh_object()
        self.pull(obj, self.grab(MIDDLE), (0.3, 0.0, 0.0))
        posed = shown_positions(obj)
        begun = self.pull(obj, self.grab(TOP), (0.0, 0.0, 0.0))
        self.assertEqual([spec.name for spec in begun.inputs.specs], ["Pull Pin 1", "Pull 1", "Rest"])
        self.assert_close(shown_positions(obj)[MIDDLE], posed[MIDDLE], 1e-5)
        self.pull(obj, self.grab(TOP), (0.0, 0.4, 0.0))
        self.assert_close(shown_positions(obj)[MIDDLE], posed[MIDDLE], 1e-4)
        self.assert_close(shown_positions(obj)[TOP], posed[TOP] + (0.0, 0.4, 0.0), 1e-3)
        self.assertEqual(len(obj.arap.pull_pins), 2)

    def test_a_pose_at_half_its_value_does_not_jump(self):
        obj = mesh_object()
        self.pull(obj, self.grab(MIDDLE), (0.4, 0.0, 0.0))
        obj.data.shape_keys.key_blocks["ARAP"].value = 0.5
        bpy.context.view_layer.update()
        before = shown_positions(obj)
        begun = self.api_pull.begin_pull(obj, bpy.context.evaluated_depsgraph_get(), [self.grab(TOP)])
        self.assert_close(begun.shown, before, 1e-6)

    def test_another_radius_before_the_mesh_is_bound_does_not_jump_either(self):
        obj = mesh_object()
        self.pull(obj, self.grab(MIDDLE), (0.4, 0.0, 0.0))
        obj.data.shape_keys.key_blocks["ARAP"].value = 0.5
        bpy.context.view_layer.update()
        before = shown_positions(obj)
        scene = module("pull.scene").PullScene(obj, [self.grab(TOP)])
        scene.begin_bind().drop()
        scene.grab([self.grab(TOP[:4])])
        binding = scene.begin_bind()
        binding.start()
        binding.wait()
        binding.adopt()
        self.assert_close(module("core.sessions").get("Tube").session.positions, before, 1e-6)

    def test_a_bind_dropped_before_it_has_begun_leaves_the_former_session(self):
        obj = posable()
        former = module("follow.update").prepare_session(obj)
        sessions, session_binding = module("core.sessions"), module("follow.bind")
        inputs = module("scene.inputs").read_input(obj, bpy.context.evaluated_depsgraph_get())
        binding = session_binding.SessionBinding(obj, inputs)
        self.assertIsNone(sessions.get("Tube"), "it is the bind's")
        binding.drop()
        self.assertIs(sessions.get("Tube").session, former)
        binding = session_binding.SessionBinding(obj, inputs)
        binding.start()
        binding.drop()
        self.assertIsNone(sessions.get("Tube"), "the thread may be in it still")
        binding.wait()

    def test_with_a_pin_all_else_gives_way(self):
        obj = mesh_object()
        rest = rest_positions(obj)
        self.pull_pins.add(obj, [self.grab(BOTTOM, 0.0)])
        begun = self.pull(obj, self.grab(TOP, 0.2), (0.6, 0.0, 0.0))
        self.assertEqual([spec.name for spec in begun.inputs.specs], ["Pull Pin 1", "Pull 1"])
        posed = shown_positions(obj)
        self.assert_close(posed[BOTTOM], rest[BOTTOM], 1e-5)
        self.assertGreater(posed[MIDDLE][:, 0].mean(), 0.05)

    def test_pins_and_handles_of_the_object_hold_where_they_are_shown(self):
        obj = posable()
        begun = self.pull(obj, self.grab(MIDDLE, 0.2), (0.3, 0.0, 0.0))
        self.assertEqual([spec.name for spec in begun.inputs.specs], ["Feet", "Head", "Pull 1"])
        rest, posed = rest_positions(obj), shown_positions(obj)
        self.assert_close(posed[[*BOTTOM, *TOP]], rest[[*BOTTOM, *TOP]], 1e-5)

    def test_what_is_held_already_cannot_be_pulled(self):
        obj = posable()
        self.assert_error(
            ValueError,
            "This part of 'Tube' is held by a pin or handle: pull elsewhere, or move the handle",
            self.api_pull.begin_pull,
            obj,
            bpy.context.evaluated_depsgraph_get(),
            [self.grab(BOTTOM)],
        )

    def test_a_key_that_would_not_show_the_pull_is_refused(self):
        obj = mesh_object()
        self.pull(obj, self.grab(MIDDLE), (0.3, 0.0, 0.0))
        obj.data.shape_keys.key_blocks["ARAP"].mute = True
        self.assert_error(
            ValueError,
            "Shape key 'ARAP' of 'Tube' is muted (a bake does that), so the pose would not show: "
            "unmute it, and mute or remove the baked keys",
            self.api_pull.begin_pull,
            obj,
            bpy.context.evaluated_depsgraph_get(),
            [self.grab(TOP)],
        )

    def test_shared_meshes_are_refused(self):
        obj = mesh_object()
        other = bpy.data.objects.new("Twin", obj.data)
        self.scene.collection.objects.link(other)
        self.assert_error(
            ValueError,
            "The mesh of 'Tube' is shared with other objects, which would deform too: make it single-user "
            "(Object > Relations > Make Single User > Object & Data)",
            self.api_pull.begin_pull,
            obj,
            bpy.context.evaluated_depsgraph_get(),
            [self.grab(MIDDLE)],
        )

    def test_the_motion_is_that_of_what_is_seen(self):
        """An armature-like turn comes after the pose: what is seen goes where the mouse wants it."""
        obj = mesh_object()
        pivot = bpy.data.objects.new("Pivot", None)
        self.scene.collection.objects.link(pivot)
        hook = obj.modifiers.new("Hook", "HOOK")
        hook.object = pivot
        hook.vertex_indices_set(list(range(len(obj.data.vertices))))
        pivot.rotation_euler.z = np.pi / 2.0
        bpy.context.view_layer.update()
        before = shown_positions(obj)
        self.seen_mesh.clear()
        self.pull(obj, self.grab(MIDDLE), (0.3, 0.0, 0.0))
        self.assert_close(shown_positions(obj)[MIDDLE], before[MIDDLE] + (0.3, 0.0, 0.0), 1e-3)
        rest = rest_positions(obj)
        self.assert_close(key_positions(obj)[MIDDLE], rest[MIDDLE] - (0.0, 0.3, 0.0), 1e-3)

    def test_posing_with_handles_again_needs_no_bind(self):
        obj = posable()
        session = module("follow.update").prepare_session(obj)
        begun = self.api_pull.begin_pull(obj, bpy.context.evaluated_depsgraph_get(), [self.grab(MIDDLE)])
        former = module("core.sessions").get(obj.name)
        again = module("core.sessions").rebuild(begun.inputs, former)
        self.assertIs(again, session)
        module("follow.mesh").adopt(obj, begun.inputs, again)
        self.assertEqual(unfit(obj), "The pins or handles of 'Tube' have changed")
        self.assertIs(module("follow.update").prepare_session(obj), session)
        self.assertEqual(unfit(obj, is_thorough=True), "")


class PinsTest(PullTest):
    def test_the_last_one_has_the_vertices(self):
        obj = mesh_object()
        self.pull_pins.add(obj, [self.grab([1, 2, 3]), self.grab([5])])
        self.pull_pins.add(obj, [self.grab([3, 4, 5], 0.0)])
        self.assertEqual([pin.vertices.tolist() for pin in obj.arap.pull_pins], [[1, 2], [3, 4, 5]])
        self.assertEqual([pin.reach for pin in obj.arap.pull_pins], [1.0, 0.0])
        self.assertEqual(self.pull_pins.find(obj, np.array([2, 4])), [0, 1])

    def test_real_ones_leave_the_mesh_where_it_is(self):
        obj = mesh_object()
        obj.arap.accuracy = 1e-7
        obj.arap.max_iterations = 5000
        self.pull(obj, self.grab(MIDDLE), (0.3, 0.0, 0.0))
        posed = shown_positions(obj)
        made = self.pull_pins.make_real(obj, bpy.context.evaluated_depsgraph_get())
        self.assertEqual(made, (1, 1))
        self.assertEqual(len(obj.arap.pull_pins), 0)
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(obj), posed, 1e-6)
        handle = obj.arap.handles[0]
        self.assert_close(handle.target.matrix_world.translation, posed[MIDDLE].mean(axis=0), 1e-4)
        self.api.solve(obj)
        self.assert_close(shown_positions(obj)[MIDDLE], posed[MIDDLE], 1e-3)
        self.assert_close(shown_positions(obj), posed, 5e-3)

    def test_what_was_clicked_at_rest_becomes_a_pin(self):
        obj = mesh_object()
        self.pull_pins.add(obj, [self.grab(BOTTOM, 0.0)])
        self.pull(obj, self.grab(TOP), (0.3, 0.0, 0.0))
        self.assertEqual(self.pull_pins.make_real(obj, bpy.context.evaluated_depsgraph_get()), (1, 1))
        self.assertEqual([pin.name for pin in obj.arap.pins], ["Hold"])

    def test_without_any_there_is_nothing_to_make_real(self):
        self.assert_error(
            ValueError,
            "Nothing of 'Tube' has been pulled or pinned with the tool: drag or click it first",
            self.pull_pins.make_real,
            mesh_object(),
            bpy.context.evaluated_depsgraph_get(),
        )

    def test_a_session_of_a_pull_is_not_taken_for_one_of_the_handles_made_of_it(self):
        """Both hold the same vertices as strongly, but from where they were shown and from rest."""
        for is_live in (False, True):
            with self.subTest(is_live=is_live):
                obj = mesh_object()
                self.api.add_pin(obj, BOTTOM, name="Feet")
                obj.arap.accuracy = 1e-7
                obj.arap.max_iterations = 5000
                self.pull(obj, self.grab(TOP), (0.3, 0.0, 0.0))
                self.pull(obj, self.grab(TOP), (0.3, 0.0, 0.0))
                self.assertEqual(self.pull_pins.make_real(obj, bpy.context.evaluated_depsgraph_get()), (1, 0))
                bpy.context.view_layer.update()
                posed = shown_positions(obj)
                if is_live:
                    obj.arap.is_live = True
                    bpy.context.view_layer.update()
                    self.assertEqual(obj.arap.live_problem, "")
                else:
                    module("core.job").run_job(module("bake.keys").begin_bake(obj, 1, 1))
                    bpy.context.view_layer.update()
                self.assert_close(shown_positions(obj)[TOP], posed[TOP], 1e-3)
                bpy.data.objects.remove(obj)

    def test_pins_of_a_mesh_that_has_other_vertices_by_now_go(self):
        obj = mesh_object()
        self.pull_pins.add(obj, [self.grab(TOP, 0.0)])
        obj.data.clear_geometry()
        obj.data.from_pydata([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)], [], [(0, 1, 2)])
        self.pull_pins.add(obj, [self.grab([0], 0.0)])
        self.assertEqual(len(obj.arap.pull_pins), 2)
        self.assertEqual(self.pull_pins.make_real(obj, bpy.context.evaluated_depsgraph_get()), (0, 1))

    def test_live_and_pulling_exclude_each_other(self):
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        common = module("ui.checks")
        self.assertEqual(common.why_not_pullable(bpy.context), "")
        obj.arap.is_live = True
        self.assertEqual(
            common.why_not_pullable(bpy.context),
            "Live would take the mesh back to its handles: switch Live off first, or move the handles",
        )

    def test_a_mesh_that_is_baked_or_pulled_is_left_alone(self):
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        common, pose_act = module("ui.checks"), module("follow.act")
        job = module("bake.keys").begin_bake(obj, 1, 2)
        self.assertEqual(common.why_not_pullable(bpy.context), "Wait for the mesh: it is baked")
        job.cancel()
        self.assertEqual(common.why_not_pullable(bpy.context), "")
        act = pose_act.PoseAct(None, is_drag=True)
        module("core.sessions").claim(obj.name, act)
        self.assertEqual(
            common.why_not_pullable(bpy.context), "The mesh is being pulled: wait until it has settled, or press Esc"
        )
        module("core.sessions").release(obj.name, act)
        self.assertEqual(common.why_not_pullable(bpy.context), "")

    def test_a_window_is_needed_to_pull(self):
        mesh_object()
        self.assertFalse(bpy.ops.arap.pull.poll())
