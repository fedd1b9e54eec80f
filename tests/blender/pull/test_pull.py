# SPDX-License-Identifier: GPL-3.0-or-later
"""Pulling without a window: the surface under a pixel, what a drag holds, temporary pins, and refusals."""

import dataclasses
import math
from types import SimpleNamespace
from unittest import mock

import numpy as np
from looks import key_positions, rest_positions, shown_positions, unfit
from mathutils import Matrix
from support import SceneTest, bpy, module, uid
from tubes import BALL, BOTTOM, LENGTH, MIDDLE, SEGMENTS, TOP, mesh_object, own_key, posable, with_balls

SIZE = (400, 300)
RIGHT = np.array([0.3, 0.0, 0.0])


class PullTest(SceneTest):
    def setUp(self) -> None:
        super().setUp()
        self.evaluated_mesh, self.hold, self.pins = (
            module("pull.evaluated_mesh"),
            module("pull.hold"),
            module("pull.pins"),
        )
        self.evaluated_mesh.clear()

    @property
    def depsgraph(self):
        return bpy.context.evaluated_depsgraph_get()

    def view(self):
        """From -y, x to the right and z up, 100 pixels a unit, the middle of the tube in the middle."""
        perspective = np.zeros((4, 4))
        perspective[0, 0], perspective[1, 2] = 2.0 * 100.0 / SIZE[0], 2.0 * 100.0 / SIZE[1]
        perspective[1, 3] = -perspective[1, 2] * LENGTH / 2.0
        perspective[2, 1] = 0.1
        perspective[3, 3] = 1.0
        return module("pull.view").View(perspective, SIZE)

    def pick(self, obj, x=200.0):
        bpy.context.view_layer.update()
        return self.evaluated_mesh.pick(obj, self.depsgraph, self.view(), (x, 150.0), 30.0)

    def seen(self, obj):
        return self.evaluated_mesh.read(obj, self.depsgraph)

    def grab(self, vertices, reach=1.0):
        return module("pull.region").PulledPatch(np.asarray(vertices, dtype=np.int32), reach)

    def begin(self, obj, grab):
        return self.hold.begin_pull(obj, self.depsgraph, [grab])

    def pull(self, obj, grab, shift):
        """A whole drag, without a mouse."""
        begun = self.begin(obj, grab)
        sessions, mesh = module("core.sessions"), module("engine.mesh")
        mesh.adopt(obj, begun.inputs, module("core.background").run(sessions.build(begun.inputs)))
        motion = np.eye(4)
        motion[:3, 3] = shift
        matrices = begun.matrices(motion, np.array(obj.matrix_world))
        for _ in range(300):
            bound = sessions.get(obj.session_uid)
            snapshot, misfit = module("engine.frame").look(obj, self.depsgraph, bound, begun.holds)
            self.assertEqual(misfit, "")
            stats = module("engine.frame").solve(snapshot, bound, matrices, initial_guess="previous")
            if stats.stop_reason == "converged":
                break
        self.pins.add(obj, begun.grabs)
        self.pins.remember_rest(obj, begun.rest, begun.shown)
        bpy.context.view_layer.update()
        return begun

    def names_of_holds(self, begun):
        return [spec.name for spec in begun.inputs.specs]


class PickTest(PullTest):
    def test_what_goes_along_is_seen_before_the_mesh_and_leads_to_the_nearest_place_of_that(self):
        body = mesh_object()
        plain = self.pick(body)
        coat = mesh_object("Coat", Matrix.Diagonal((2.0, 2.0, 1.0, 1.0)))
        self.api.attach(body, [coat])
        seen = self.pick(body)
        self.assert_close(seen.place, plain.place, 1e-4)
        self.assertLess(seen.normal[1], -0.9)
        self.assertEqual(set(seen.vertices), set(plain.vertices))
        beside = self.pick(body, 270.0)  # the ray passes the body by
        self.assertGreater(beside.place[0], 0.3)
        self.assertLessEqual(np.linalg.norm(beside.place[:2]), 0.5001)
        coat.hide_set(True)
        self.assertIsNone(self.pick(body, 270.0))
        coat.hide_set(False)
        body.arap.attachments[0].is_enabled = False
        self.assertIsNone(self.pick(body, 270.0))
        self.assertIsNone(self.pick(body, 390.0))

    def test_what_moves_a_mesh_is_found_up_to_the_first_one_that_is_switched_off(self):
        bodies, below = module("attach.hosts"), module("attach.problems").below
        body, coat, buckle = (mesh_object(name) for name in ("Body", "Coat", "Buckle"))
        self.api.attach(body, [coat], "bend")
        self.api.attach(coat, [buckle], "bend")
        self.assertEqual([bodies.moving_mesh(obj) for obj in (body, coat, buckle)], 3 * [body])
        self.assertEqual(below(body), [coat, buckle])
        body.arap.attachments[0].is_enabled = False
        self.assertEqual([bodies.moving_mesh(obj) for obj in (body, coat, buckle)], [body, coat, coat])
        self.assertEqual(below(body), [])
        coat.arap.attached_to.host = buckle  # a circle, in a damaged file
        self.assertEqual(bodies.moving_mesh(coat), coat)

    def test_the_patch_is_what_lies_within_the_circle_on_the_near_side(self):
        obj = mesh_object()
        pick = self.pick(obj)
        self.assert_close(pick.place[[0, 2]], (0.0, 2.0))
        self.assertLess(pick.place[1], -0.4)
        self.assertLess(pick.normal[1], -0.9)
        self.assertAlmostEqual(pick.radius, 0.3, places=6)
        expected = np.flatnonzero(np.linalg.norm(rest_positions(obj) - pick.place, axis=1) <= 0.3)
        np.testing.assert_array_equal(pick.vertices, expected)
        self.assertIsNone(self.pick(obj, 20.0), "beside the mesh")

    def test_what_goes_along_and_is_scaled_to_nothing_does_not_hinder(self):
        obj, coat = mesh_object("Body"), mesh_object("Coat")
        self.api.attach(obj, [coat], "bend")
        coat.scale = (0.0, 0.0, 0.0)
        bpy.context.view_layer.update()
        self.assertLess(self.pick(obj).place[1], -0.4)

    def test_a_moved_turned_and_scaled_object_is_found_where_it_is_seen(self):
        obj = mesh_object()
        self.pick(obj)  # read again after the change
        obj.location, obj.scale, obj.rotation_euler = (1.0, 2.0, 0.5), (1.0, 0.5, 0.8), (0.0, 0.0, 0.3)
        self.assertIsNone(self.pick(obj, 120.0))
        pick = self.pick(obj, 300.0)
        self.assertAlmostEqual(pick.place[0], 1.0, places=5)
        seen = self.seen(obj).positions
        world = np.array(obj.matrix_world)
        self.assert_close(seen, rest_positions(obj) @ world[:3, :3].T + world[:3, 3])
        distance = np.linalg.norm(seen - pick.place, axis=1)
        np.testing.assert_array_equal(pick.vertices, np.flatnonzero(distance <= pick.radius))

    def test_another_mesh_with_as_many_faces_is_read_again(self):
        obj, turned = mesh_object(), mesh_object("Turned")
        turned.data.transform(Matrix.Diagonal((1.0, 1.0, -1.0, 1.0)))
        turned.data.flip_normals()  # another order of corners
        self.seen(obj)
        obj.data = turned.data
        bpy.context.view_layer.update()
        found, expected = (self.seen(item).topology.corner_vertices for item in (obj, turned))
        np.testing.assert_array_equal(found, expected)

    def test_the_last_pick_is_forgotten_with_the_file(self):
        draw = module("pull.draw")
        draw.hover(bpy.context, mesh_object(), self.view(), (SIZE[0] / 2, SIZE[1] / 2), 30.0)
        self.assertIsNotNone(draw._hover[1])
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        self.assertIsNone(draw._hover[1])

    def test_other_shape_keys_and_deforming_modifiers_count(self):
        obj = mesh_object()
        own_key(obj, "Aside", 1.0)
        obj.modifiers.new("Up", "DISPLACE").direction = "Z"
        obj.modifiers["Up"].mid_level = 0.5
        self.assertIsNone(self.pick(obj, 120.0))
        self.assertAlmostEqual(self.pick(obj, 300.0).place[0], 1.0, places=5)
        self.assert_close(self.seen(obj).positions, shown_positions(obj))

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
        obj.data.transform(Matrix.Translation((1.2, 0.0, 0.0)))
        obj.modifiers.new("Mirror", "MIRROR")
        self.assertIsNotNone(self.pick(obj, 320.0))
        self.assert_error(
            ValueError, "This part of 'Tube' is made by a modifier: pull the mesh itself", self.pick, obj, 80.0
        )

    def test_what_cannot_be_traced_back_is_refused(self):
        obj = mesh_object()
        obj.modifiers.new("Bevel", "BEVEL").limit_method = "NONE"
        message = "Modifier 'Bevel' of 'Tube' makes other vertices: turn it off in the viewport to pull"
        self.assert_error(ValueError, message, self.pick, obj)
        obj.modifiers["Bevel"].show_viewport = False
        self.assertIsNotNone(self.pick(obj))

    def test_a_pin_behind_the_viewer_hides_no_other_one(self):
        draw = module("pull.draw")
        dots = np.array([[10.0, 20.0], [np.nan, np.nan], [30.0, 40.0]])
        with mock.patch.object(draw.batches, "draw_pixels") as draw_pixels:
            draw.draw_dots(dots, 5.0, (1.0, 1.0, 1.0, 1.0))
        kind, corners, _ = draw_pixels.call_args.args
        self.assertEqual(kind, "TRIS")
        self.assert_close(corners.reshape(2, -1, 3, 2)[:, :, 0], np.repeat(dots[[0, 2], None], 48, axis=1), 0.0)

    def test_the_discs_of_pins_face_the_viewer_in_front_of_the_surface(self):
        draw = module("pull.draw")
        place = np.array([0.4, -0.5, 1.0])
        discs = draw.facing_discs(self.view(), place[None], 5.0).reshape(-1, 3, 3)
        radius = 5.0 * bpy.context.preferences.system.ui_scale / 100.0
        self.assert_close(discs[:, 0], np.tile(place - (0.0, radius, 0.0), (48, 1)))
        self.assert_close(np.linalg.norm(discs[:, 1] - discs[:, 0], axis=1), radius)
        self.assert_close(discs[:, :, 1], place[1] - radius)

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
        find_drawn_object = module("ui.checks").find_drawn_object
        self.assertEqual(find_drawn_object(context), obj)
        obj.hide_set(True)
        bpy.context.view_layer.update()
        self.assertIsNone(find_drawn_object(context))
        obj.hide_set(False)
        bpy.context.view_layer.update()
        for owner, name in ((space, "show_object_viewport_mesh"), (space.overlay, "show_overlays")):
            setattr(owner, name, False)
            self.assertIsNone(find_drawn_object(context))
            setattr(owner, name, True)
            self.assertEqual(find_drawn_object(context), obj)

    def test_triangles_of_a_patch_cover_its_whole_faces(self):
        seen = self.seen(mesh_object())
        for patch, n in (([*MIDDLE, *(i + SEGMENTS for i in MIDDLE)], 2 * SEGMENTS), (BOTTOM, SEGMENTS - 2)):
            triangles = self.evaluated_mesh.patch_triangles(seen, np.array(patch, dtype=np.int32))
            self.assertEqual(triangles.shape, (n, 3))


class DragTest(PullTest):
    def test_what_goes_along_is_pulled_too(self):
        obj, twin = posable(), mesh_object("Twin")
        self.api.attach(obj, [twin])
        self.pull(obj, self.grab(MIDDLE), RIGHT)
        self.assertGreater((key_positions(twin) - rest_positions(twin))[MIDDLE, 0].mean(), 0.25)
        self.assert_close(key_positions(twin), key_positions(obj), 0.02)

    def at_half_its_value(self):
        """A pulled tube whose key has value 0.5."""
        obj = mesh_object()
        self.pull(obj, self.grab(MIDDLE), (0.4, 0.0, 0.0))
        obj.data.shape_keys.key_blocks["ARAP"].value = 0.5
        bpy.context.view_layer.update()
        return obj, shown_positions(obj)

    def test_the_rest_is_held_beyond_the_reach(self):
        obj = mesh_object()
        rest = rest_positions(obj)
        self.pull(obj, self.grab(MIDDLE), RIGHT)
        posed = shown_positions(obj)
        self.assert_close(posed[MIDDLE], rest[MIDDLE] + RIGHT, 1e-4)
        self.assert_close(posed[[*BOTTOM, *TOP]], rest[[*BOTTOM, *TOP]], 1e-5)
        self.assertEqual(obj.data.shape_keys.key_blocks["ARAP"].value, 1.0)

    def test_the_next_drag_begins_where_the_mesh_is_and_leaves_what_was_pulled(self):
        obj = mesh_object()
        self.pull(obj, self.grab(MIDDLE), RIGHT)
        posed = shown_positions(obj)
        begun = self.pull(obj, self.grab(TOP), (0.0, 0.0, 0.0))
        self.assertEqual(self.names_of_holds(begun), ["Pull Pin 1", "Pull 1", "Everything Else"])
        self.assert_close(shown_positions(obj)[MIDDLE], posed[MIDDLE], 1e-5)
        self.pull(obj, self.grab(TOP), (0.0, 0.4, 0.0))
        self.assert_close(shown_positions(obj)[MIDDLE], posed[MIDDLE], 1e-4)
        self.assert_close(shown_positions(obj)[TOP], posed[TOP] + (0.0, 0.4, 0.0), 1e-3)
        self.assertEqual(len(obj.arap.pull_pins), 2)

    def test_a_pose_at_half_its_value_does_not_jump(self):
        obj, before = self.at_half_its_value()
        self.assert_close(self.begin(obj, self.grab(TOP)).shown, before, 1e-6)

    def test_another_radius_before_the_mesh_is_bound_does_not_jump_either(self):
        obj, before = self.at_half_its_value()
        scene = module("pull.scene").PullScene(obj, [self.grab(TOP)])
        scene.begin_bind().drop()
        scene.grab([self.grab(TOP[:4])])
        binding = scene.begin_bind()
        binding.step(math.inf)
        binding.adopt()
        self.assert_close(module("core.sessions").get(uid("Tube")).session.positions, before, 1e-6)

    def test_a_bind_that_is_dropped_or_fails_leaves_the_former_session(self):
        obj = posable()
        former = module("engine.update").prepare_session(obj)
        sessions, mesh = module("core.sessions"), module("engine.mesh")
        self.api.add_pin(obj, MIDDLE)
        inputs = module("scene.inputs").read_input(obj, self.depsgraph)
        binding = mesh.SessionBinding(obj, inputs)
        self.assertIsNone(sessions.get(uid("Tube")), "the bind uses it")
        binding.drop()
        self.assertIs(sessions.get(uid("Tube")).session, former)
        empty = dataclasses.replace(inputs, specs=())
        binding = mesh.SessionBinding(obj, empty)
        self.assertFalse(binding.step(math.inf))
        message = "No vertex is pinned or has a handle: add a pin or a handle, or give its group weight"
        self.assert_error(ValueError, message, binding.adopt)
        self.assertIs(sessions.get(uid("Tube")).session, former)
        binding = mesh.SessionBinding(obj, inputs)
        binding.step(math.inf)
        binding.drop()
        self.assertIsNone(sessions.get(uid("Tube")), "it has other handles now")

    def test_with_a_pin_all_else_gives_way(self):
        obj = mesh_object()
        self.pins.add(obj, [self.grab(BOTTOM, 0.0)])
        begun = self.pull(obj, self.grab(TOP, 0.2), (0.6, 0.0, 0.0))
        self.assertEqual(self.names_of_holds(begun), ["Pull Pin 1", "Pull 1"])
        posed = shown_positions(obj)
        self.assert_close(posed[BOTTOM], rest_positions(obj)[BOTTOM], 1e-5)
        self.assertGreater(posed[MIDDLE][:, 0].mean(), 0.05)

    def test_pins_and_handles_of_the_object_hold_where_they_are_shown(self):
        obj = posable()
        begun = self.pull(obj, self.grab(MIDDLE, 0.2), RIGHT)
        self.assertEqual(self.names_of_holds(begun), ["Feet", "Head", "Pull 1"])
        self.assert_close(shown_positions(obj)[[*BOTTOM, *TOP]], rest_positions(obj)[[*BOTTOM, *TOP]], 1e-5)

    def test_loose_pieces_go_along_with_the_limb(self):
        """An eye near the end that is pulled, one near the other end, and a ball far away."""
        obj = with_balls((0.5, 0.0, 0.9 * LENGTH), (0.5, 0.0, 0.1 * LENGTH), (4.0, 0.0, 0.0))
        obj.arap.controls.clear()
        first = len(rest_positions(obj)) - 3 * BALL
        eye, other, far = (slice(first + i * BALL, first + (i + 1) * BALL) for i in range(3))
        self.pull(obj, self.grab(TOP), RIGHT)
        self.pull(obj, self.grab(TOP), RIGHT)
        rest, pulled = rest_positions(obj), key_positions(obj)
        self.assertGreater((pulled - rest)[eye, 0].min(), 0.2)
        self.assert_close(pulled[other], rest[other], 2e-5)
        self.assert_close(pulled[far], rest[far], 2e-5)
        self.pins.make_real(obj, self.depsgraph)
        self.api.solve(obj)
        self.assert_close(key_positions(obj), pulled, 2e-3)

    def test_refusals(self):
        muted = mesh_object("Muted")
        self.pull(muted, self.grab(MIDDLE), RIGHT)
        muted.data.shape_keys.key_blocks["ARAP"].mute = True
        shared = mesh_object("Shared")
        self.scene.collection.objects.link(bpy.data.objects.new("Twin", shared.data))
        held = "This part of 'Tube' is held by a pin or handle: pull another part, or move the handle"
        for obj, vertices, message in (
            (posable(), BOTTOM, held),
            (muted, TOP, "Shape key 'ARAP' of 'Muted' is muted"),
            (shared, MIDDLE, "The mesh of 'Shared' is shared with other objects"),
        ):
            with self.assertRaisesRegex(ValueError, f"^{message}"):
                self.begin(obj, self.grab(vertices))

    def test_the_motion_is_that_of_what_is_seen(self):
        """A turn by a modifier comes after the pose: the visible piece goes with the mouse."""
        obj = mesh_object()
        pivot = bpy.data.objects.new("Pivot", None)
        self.scene.collection.objects.link(pivot)
        hook = obj.modifiers.new("Hook", "HOOK")
        hook.object = pivot
        hook.vertex_indices_set(list(range(len(obj.data.vertices))))
        pivot.rotation_euler.z = np.pi / 2.0
        bpy.context.view_layer.update()
        before = shown_positions(obj)
        self.evaluated_mesh.clear()
        self.pull(obj, self.grab(MIDDLE), RIGHT)
        self.assert_close(shown_positions(obj)[MIDDLE], before[MIDDLE] + RIGHT, 1e-3)
        self.assert_close(key_positions(obj)[MIDDLE], rest_positions(obj)[MIDDLE] - (0.0, 0.3, 0.0), 1e-3)

    def test_posing_with_handles_again_needs_no_bind(self):
        obj = posable()
        prepare_session = module("engine.update").prepare_session
        session = prepare_session(obj)
        begun = self.begin(obj, self.grab(MIDDLE))
        sessions = module("core.sessions")
        again = module("core.background").run(sessions.rebuild(begun.inputs, sessions.get(obj.session_uid)))
        self.assertIs(again, session)
        module("engine.mesh").adopt(obj, begun.inputs, again)
        self.assertEqual(unfit(obj), "The pins or handles of 'Tube' have changed")
        self.assertIs(prepare_session(obj), session)
        self.assertEqual(unfit(obj, is_thorough=True), "")


class PinsTest(PullTest):
    def make_real(self, obj):
        made = self.pins.make_real(obj, self.depsgraph)
        bpy.context.view_layer.update()
        return made

    def test_the_last_one_has_the_vertices(self):
        obj = mesh_object()
        self.pins.add(obj, [self.grab([1, 2, 3]), self.grab([5])])
        self.pins.add(obj, [self.grab([3, 4, 5], 0.0)])
        self.assertEqual([pin.vertices.tolist() for pin in obj.arap.pull_pins], [[1, 2], [3, 4, 5]])
        self.assertEqual([pin.reach for pin in obj.arap.pull_pins], [1.0, 0.0])
        self.assertEqual(self.pins.find(obj, np.array([2, 4])), [0, 1])

    def test_real_ones_leave_the_mesh_where_it_is(self):
        obj = mesh_object()
        obj.arap.accuracy, obj.arap.max_iterations = 1e-7, 5000
        self.pull(obj, self.grab(MIDDLE), RIGHT)
        posed = shown_positions(obj)
        self.assertEqual(self.make_real(obj), (1, 1))
        self.assertEqual(len(obj.arap.pull_pins), 0)
        self.assertEqual([pin.name for pin in obj.arap.pins], ["Everything Else"])
        self.assert_close(shown_positions(obj), posed, 1e-6)
        handle = obj.arap.handles[0]
        self.assert_close(handle.target.matrix_world.translation, posed[MIDDLE].mean(axis=0), 1e-4)
        self.api.solve(obj)
        self.assert_close(shown_positions(obj), posed, 4e-4)

    def test_nor_do_those_of_several_pulls_and_points_move_it(self):
        obj = mesh_object()
        obj.arap.accuracy, obj.arap.max_iterations, obj.arap.rigidity = 1e-7, 5000, 20.0
        self.pull(obj, self.grab(MIDDLE), RIGHT)
        self.pull(obj, self.grab([TOP[0]], 2.0), -RIGHT)
        self.pull(obj, self.grab([TOP[0] - 4 * SEGMENTS], 1.5), RIGHT[[1, 0, 2]])
        posed = shown_positions(obj)
        self.assertEqual(self.make_real(obj), (3, 1))
        self.assert_close(shown_positions(obj), posed, 1e-6)
        self.api.solve(obj)
        self.assert_close(shown_positions(obj), posed, 4e-4)

    def test_what_was_clicked_at_rest_becomes_a_pin(self):
        obj = mesh_object()
        self.pins.add(obj, [self.grab(BOTTOM, 0.0)])
        self.pull(obj, self.grab(TOP), RIGHT)
        self.assertEqual(self.make_real(obj), (1, 1))
        self.assertEqual([pin.name for pin in obj.arap.pins], ["Bottom"])

    def test_the_new_handle_is_in_hand_and_not_the_pin_of_everything_else(self):
        obj = mesh_object()
        self.pull(obj, self.grab(TOP), RIGHT)
        bpy.context.view_layer.objects.active = obj
        self.assertEqual(bpy.ops.arap.pull_make_real(), {"FINISHED"})
        handle = obj.arap.handles[-1]
        self.assertEqual((bpy.context.object, bpy.context.selected_objects), (handle.target, [handle.target]))
        self.assertEqual(obj.arap.controls[obj.arap.chosen_control_index], handle)

    def test_without_any_there_is_nothing_to_make_real(self):
        message = "Nothing of 'Tube' has been pulled or pinned with the tool: drag or click it first"
        self.assert_error(ValueError, message, self.make_real, mesh_object())

    def test_a_session_of_a_pull_is_not_taken_for_one_of_the_handles_made_of_it(self):
        """Both hold the same vertices as strongly, but from where they were shown and from rest."""
        for use_follow in (False, True):
            with self.subTest(use_follow=use_follow):
                obj = mesh_object()
                self.api.add_pin(obj, BOTTOM, name="Feet")
                obj.arap.accuracy, obj.arap.max_iterations = 1e-7, 5000
                for _ in range(2):
                    self.pull(obj, self.grab(TOP), RIGHT)
                self.assertEqual(self.make_real(obj), (1, 0))
                posed = shown_positions(obj)
                if use_follow:
                    obj.arap.use_follow = True
                    bpy.context.view_layer.update()
                    self.assertEqual(obj.arap.follow_error, "")
                else:
                    self.api.bake_animation(obj, 1, 1)
                    bpy.context.view_layer.update()
                self.assert_close(shown_positions(obj)[TOP], posed[TOP], 1e-3)
                bpy.data.objects.remove(obj)

    def test_pins_of_a_mesh_that_has_other_vertices_by_now_go(self):
        obj = mesh_object()
        self.pins.add(obj, [self.grab(TOP, 0.0)])
        obj.data.clear_geometry()
        obj.data.from_pydata([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)], [], [(0, 1, 2)])
        self.pins.add(obj, [self.grab([0], 0.0)])
        self.assertEqual(len(obj.arap.pull_pins), 2)
        self.assertEqual(self.make_real(obj), (0, 1))


class SettingsTest(PullTest):
    def test_reach_is_offered_only_where_it_has_an_effect(self):
        obj = mesh_object()
        bpy.context.view_layer.objects.active = obj
        for reach, is_offered in ((None, True), (1.0, True), (0.0, False)):  # nothing, pulled, pinned by a click
            if reach is not None:
                self.pins.add(obj, [self.grab(TOP, reach)])
            layout = mock.Mock()
            module("pull.tool").ArapPullTool.draw_settings(bpy.context, layout, None)
            row = layout.row.return_value
            offered = any(call.args[1:] == ("use_auto_reach",) for call in row.prop.call_args_list)
            self.assertEqual((offered, layout.label.called), (is_offered, not is_offered))


class ReasonTest(SceneTest):
    def test_why_a_mesh_cannot_be_pulled(self):
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        sessions = module("core.sessions")

        def check(begin):
            reason = module("ui.checks").why_not_pullable(bpy.context)
            self.assertEqual((reason[: len(begin)], bool(reason)), (begin, bool(begin)))

        check("")
        job = module("bake.keys").BakeJob(obj, 1, 2)
        check("Wait for the mesh: it is baked")
        job.cancel()
        check("")
        act = module("engine.interaction").Interaction(None, is_drag=True)
        sessions.lock(obj, act)
        check("The mesh is being pulled: wait until it ")
        sessions.unlock(obj.session_uid, act)
        check("")
        obj.arap.use_follow = True
        check("")
        self.assertFalse(bpy.ops.arap.pull.poll(), "there is no window")
