# SPDX-License-Identifier: GPL-3.0-or-later
"""Making, removing and resetting pins and handles."""

from unittest import mock

import numpy as np
from looks import group_of, in_world, key_positions, rest_positions, shown_positions
from mathutils import Matrix
from support import SceneTest, bpy, module
from tubes import (
    BOTTOM,
    LENGTH,
    MIDDLE,
    PLACED,
    SEGMENTS,
    TOP,
    armature,
    bend,
    empty_at,
    mesh_object,
    move,
    posable,
    solved,
)

STAYS = 1e-4 * (LENGTH**2 + 2.0) ** 0.5


def group(obj, vertices, weight):
    """A new group of these vertices; its name."""
    made = obj.vertex_groups.new(name="Soft")
    made.add(list(vertices), weight, "REPLACE")
    return made.name


def misfit(rest, shown):
    """How far ``shown`` is from the nearest place of ``rest`` as a rigid body."""
    rest, shown = rest - rest.mean(axis=0), shown - shown.mean(axis=0)
    u, _, vt = np.linalg.svd(shown.T @ rest)
    u[:, 2] *= np.sign(np.linalg.det(u @ vt))
    return np.linalg.norm(rest @ (u @ vt).T - shown, axis=1).max()


class HandleTest(SceneTest):
    def test_the_empty_stands_at_the_centroid_sized_to_the_group_and_follows_the_object(self):
        obj = mesh_object(matrix=PLACED)
        handle = obj.arap.controls[self.api.add_handle(obj, TOP, name="Head")]
        bpy.context.view_layer.update()
        points = in_world(obj, rest_positions(obj)[TOP])
        self.assert_close(handle.target.matrix_world.translation, points.mean(axis=0), 1e-5)
        self.assert_close(np.array(handle.target.matrix_world)[:3, :3], np.eye(3), 1e-5)
        radius = np.linalg.norm(points - points.mean(axis=0), axis=1).max()
        self.assertAlmostEqual(handle.target.empty_display_size, radius, places=5)
        self.assertIs(handle.target.parent, obj)
        self.assertEqual(group_of(obj, handle.vertex_group), dict.fromkeys(TOP, 1.0))
        self.assertEqual(list(handle.target.users_collection), list(obj.users_collection))

    def test_the_empty_is_put_where_it_is_evaluated(self):
        """Of the mesh's collections that may be an excluded one, one of another scene, or none."""
        obj = mesh_object()
        excluded, enabled, elsewhere = (bpy.data.collections.new(name) for name in ("Excluded", "Enabled", "Elsewhere"))
        bpy.data.scenes.new("Other").collection.children.link(elsewhere)
        root = self.scene.collection
        for collection in (excluded, enabled):
            root.children.link(collection)
        for collection in (elsewhere, excluded, enabled):
            collection.objects.link(obj)
        root.objects.unlink(obj)
        bpy.context.view_layer.layer_collection.children["Excluded"].exclude = True
        bpy.context.view_layer.update()
        for expected in (enabled, root):
            handle = obj.arap.controls[self.api.add_handle(obj, TOP)]
            self.assertEqual(list(handle.target.users_collection), [expected])
            bpy.context.view_layer.update()
            self.assertEqual(module("setup.controls").control_problem(obj, handle), "")
            if expected == enabled:
                enabled.objects.unlink(obj)

    def test_adding_a_handle_to_a_posed_mesh_never_moves_it(self):
        """The empty appears where the pose has taken the group, turned as the group is turned."""
        for matrix in (Matrix(), PLACED):
            with self.subTest(matrix):
                obj = solved(matrix=matrix)
                posed = key_positions(obj)
                handle = obj.arap.controls[self.api.add_handle(obj, MIDDLE, name="Waist")]
                bpy.context.view_layer.update()
                self.assert_close(key_positions(obj), posed, 0.0)
                shown = in_world(obj, posed[MIDDLE])
                self.assert_close(handle.target.matrix_world.translation, shown.mean(axis=0), 1e-4)
                # At rest it stands at the centroid at rest: that is where a reset takes it.
                at_rest = np.array(obj.matrix_world) @ np.array(handle.rest)
                self.assert_close(at_rest[:3, 3], in_world(obj, rest_positions(obj)[MIDDLE]).mean(axis=0), 1e-4)
                # The ring was bent out of shape, and is held so.
                out_of_shape = misfit(in_world(obj, rest_positions(obj)[MIDDLE]), shown)
                self.assertGreater(out_of_shape, 4.0 * STAYS)
                self.api.solve(obj)
                self.assert_close(key_positions(obj), posed, STAYS)
                self.api.reset_handles(obj)
                bpy.context.view_layer.update()
                self.api.solve(obj)
                self.assert_close(key_positions(obj), rest_positions(obj), STAYS)

    def test_nor_does_a_pin_or_a_soft_group_that_shares_vertices_with_others(self):
        soft = [*range(6 * SEGMENTS, 12 * SEGMENTS)]
        for what, add in {
            "a pin": lambda obj: self.api.add_pin(obj, MIDDLE),
            "a pin in a soft handle": lambda obj: self.api.add_pin(obj, range(10 * SEGMENTS, 13 * SEGMENTS)),
            "a soft pin": lambda obj: self.api.add_pin_group(obj, group(obj, soft, 0.3)),
            "a stronger soft pin": lambda obj: self.api.add_pin_group(obj, group(obj, soft, 0.9)),
        }.items():
            with self.subTest(what):
                obj = posable()
                handle = obj.arap.controls[self.api.add_handle_for(obj, empty_at((0.0, 0.0, 2.5)))]
                handle.vertex_group = group(obj, range(9 * SEGMENTS, 12 * SEGMENTS), 0.6)
                move(handle.target, (0.5, 0.0, 0.0), (0.0, 0.5, 0.0))
                bend(obj)
                self.api.solve(obj)
                posed = key_positions(obj)
                add(obj)
                self.api.solve(obj)
                self.assert_close(key_positions(obj), posed, STAYS)

    def test_a_pin_chosen_again_stays_and_one_switched_on_again_holds_what_is_shown(self):
        obj = solved()
        posed = key_positions(obj)
        pin = obj.arap.controls[self.api.add_pin_group(obj, self.api.add_pin(obj, MIDDLE, name="Waist"))]
        self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, STAYS)
        number = pin.base_id
        self.assertEqual(obj.arap.controls[self.api.add_pin_group(obj, "Waist")].base_id, number)

    def test_the_pose_applied_as_rest_is_held_as_it_is(self):
        obj = solved()
        self.api.add_pin(obj, MIDDLE)
        self.api.apply_pose_as_rest(obj)
        bpy.context.view_layer.update()
        rest = rest_positions(obj)
        self.api.solve(obj)
        self.assert_close(key_positions(obj), rest, STAYS)

    def test_a_damaged_base_is_the_mesh_at_rest(self):
        obj = solved()
        pin = obj.arap.controls[self.api.add_pin(obj, MIDDLE)]
        vertices, offsets = pin.base
        self.assertEqual(vertices.tolist(), MIDDLE)
        pin.set_base(vertices, offsets * np.nan)
        self.assertEqual(len(pin.base[0]), 0)
        pin.set_base(vertices, offsets)
        obj.data.attributes.remove(obj.data.attributes[".arap_base"])
        obj.data.attributes.new(".arap_base", "FLOAT", "FACE")
        self.assertEqual(len(pin.base[0]), 0)
        self.api.solve(obj)
        self.assert_close(key_positions(obj)[MIDDLE], rest_positions(obj)[MIDDLE])

    def test_handles_for_empties_take_the_vertices_around_them_or_the_nearest(self):
        obj = mesh_object(matrix=PLACED)
        world = in_world(obj, rest_positions(obj))
        near, far = empty_at(world[TOP].mean(axis=0), "Near"), empty_at(world[BOTTOM[0]] + 30.0, "Far")
        radius = 1.5
        names = module("setup.handles").add_handles_for(obj, [(near, ""), (far, "")], radius=radius)
        centre = np.array(near.matrix_world.translation)
        within = np.flatnonzero(np.linalg.norm(world - centre, axis=1) <= radius)
        self.assertGreater(len(within), 4)
        self.assertEqual(names, ["Near", "Far"])
        handles = [obj.arap.controls[name] for name in names]
        self.assertEqual(sorted(group_of(obj, handles[0].vertex_group)), within.tolist())
        nearest = np.linalg.norm(world - np.array(far.matrix_world.translation), axis=1).argmin()
        self.assertEqual(list(group_of(obj, handles[1].vertex_group)), [nearest])
        self.assertIs(handles[0].target, near)
        self.assertIsNone(near.parent)
        self.assert_close(module("scene.handle_motion").handle_matrices(obj), np.tile(np.eye(4), (2, 1, 1)), 1e-5)

    def test_handles_added_together_leave_a_posed_mesh_in_place_and_look_at_it_once(self):
        """Also if they hold the same vertices, and those of a soft handle."""
        obj = posable()
        self.api.add_pin_group(obj, group(obj, range(6 * SEGMENTS, 12 * SEGMENTS), 0.3))
        bend(obj)
        self.api.solve(obj)
        posed = key_positions(obj)
        empties = [empty_at(posed[vertex], "Control") for vertex in (*MIDDLE[:3], MIDDLE[0])]
        keep = module("scene.preserve_shape").keep_shown_shape
        with mock.patch.object(module("scene.preserve_shape"), "keep_shown_shape", side_effect=keep) as kept:
            module("setup.handles").add_handles_for(obj, [(empty, "") for empty in empties], radius=0.5)
        self.assertEqual(kept.call_count, 1)
        self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, STAYS)

    def test_handles_that_cannot_be_added_together_leave_nothing(self):
        """Nor do point handles near them keep a reach."""
        obj = posable()
        obj.arap.rigidity = 12.0
        bend(obj)
        self.api.solve(obj)
        spot = obj.arap.controls[self.api.add_handle(obj, MIDDLE[:1], name="Spot")]
        obj.arap.chosen_control_index = 0
        empties = [empty_at(key_positions(obj)[vertex], "Control") for vertex in MIDDLE[1:3]]
        hold_shown = module("scene.preserve_shape")._hold_shown

        def fail(*arguments):
            hold_shown(*arguments)
            self.assertGreater(obj.arap.controls["Spot"].reach, 0.0)
            raise MemoryError

        with mock.patch.object(module("scene.preserve_shape"), "_hold_shown", fail), self.assertRaises(MemoryError):
            module("setup.handles").add_handles_for(obj, [(empty, "") for empty in empties])
        self.assertEqual(
            ([handle.name for handle in obj.arap.handles], obj.arap.chosen_control_index), (["Head", "Spot"], 0)
        )
        spot = obj.arap.controls["Spot"]
        self.assertEqual((spot.reach, spot.base_id, len(spot.base[0])), (0.0, 0, 0))
        self.assertEqual(len(obj.vertex_groups), 3)

    def test_without_a_radius_an_empty_takes_the_nearest_vertex_of_the_pose(self):
        obj = posable()
        move(obj.arap.handles[0].target, (0.0, 3.0, -2.0))
        self.api.solve(obj)
        handle = obj.arap.controls[self.api.add_handle_for(obj, empty_at(key_positions(obj)[TOP[0]]))]
        self.assertEqual(list(group_of(obj, handle.vertex_group)), [TOP[0]])

    def test_of_what_is_selected_empties_and_bones_become_handles_and_nothing_else(self):
        obj = mesh_object()
        empty_at((0.0, 0.0, 4.0), "Control")
        for name, data in (("Sun", bpy.data.lights.new("Sun", "SUN")), ("Eye", bpy.data.cameras.new("Eye"))):
            self.scene.collection.objects.link(bpy.data.objects.new(name, data))
        bpy.ops.object.select_all(action="SELECT")
        bpy.context.view_layer.objects.active = obj
        self.assertEqual(bpy.ops.arap.handle_add(), {"FINISHED"})
        self.assertEqual([handle.target.name for handle in obj.arap.handles], ["Control"])
        self.assertFalse(bpy.ops.arap.handle_add.poll())
        rig = armature()
        self.api.add_handle_for(obj, rig, bone="Lower")
        bpy.ops.object.mode_set(mode="POSE")
        bpy.ops.pose.select_all(action="SELECT")
        self.assertEqual(bpy.ops.arap.handle_add(), {"FINISHED"})
        self.assertEqual([handle.bone for handle in obj.arap.handles], ["", "Lower", "Upper"])

    def test_bones_are_handles(self):
        obj = mesh_object()
        rig = armature()
        self.api.add_pin(obj, BOTTOM)
        handle = obj.arap.controls[self.api.add_handle_for(obj, rig, bone="Upper", radius=0.52)]
        self.assertEqual((handle.name, handle.bone), ("Upper", "Upper"))
        self.assertEqual(sorted(group_of(obj, handle.vertex_group)), MIDDLE)  # around the bone's head
        rig.location.x = 0.25
        rig.pose.bones["Upper"].location = (0.0, 0.0, 0.5)
        rig.pose.bones["Lower"].rotation_mode = "XYZ"
        rig.pose.bones["Lower"].rotation_euler = (0.3, 0.0, 0.0)
        bpy.context.view_layer.update()
        self.api.solve(obj)
        bone = np.array(rig.matrix_world @ rig.pose.bones["Upper"].matrix)
        motion = bone @ np.linalg.inv(np.array(rig.data.bones["Upper"].matrix_local))
        expected = rest_positions(obj)[MIDDLE] @ motion[:3, :3].T + motion[:3, 3]
        self.assert_close(key_positions(obj)[MIDDLE], expected, 1e-5)

    def test_reset_puts_objects_and_bones_back_parents_first(self):
        obj = mesh_object(matrix=PLACED)
        rig = armature()
        self.api.add_handle_for(obj, rig, bone="Upper")
        self.api.add_handle_for(obj, rig, bone="Lower")
        head = obj.arap.controls[self.api.add_handle(obj, TOP)]
        child = empty_at((1.0, 1.0, 1.0))
        child.parent = head.target
        self.api.add_handle_for(obj, child)
        rig.pose.bones["Lower"].location = (0.3, 0.2, 0.1)
        rig.pose.bones["Upper"].location = (0.3, 0.2, 0.1)
        move(obj.arap.handles[2].target, (1.0, 1.0, 1.0), (0.5, 0.4, 0.3))
        move(child, (1.0, 0.0, 0.0))
        self.assertGreater(
            np.abs(module("scene.handle_motion").handle_matrices(obj) - np.eye(4)).max(axis=(1, 2)).min(), 0.1
        )
        self.assertEqual(self.api.reset_handles(obj), [])
        self.assert_close(module("scene.handle_motion").handle_matrices(obj), np.tile(np.eye(4), (4, 1, 1)), 1e-5)
        child.constraints.new("COPY_LOCATION").target = empty_at((5.0, 5.0, 5.0), "Holder")
        self.assertEqual(self.api.reset_handles(obj), ["Empty"], "the constraint holds it")

    def test_size_and_location_of_an_empty(self):
        obj = mesh_object(matrix=PLACED)
        point = obj.arap.controls[self.api.add_handle(obj, [7], location=(1.0, 2.0, 3.0))].target
        bpy.context.view_layer.update()
        self.assert_close(point.matrix_world.translation, (1.0, 2.0, 3.0))
        self.assert_close(module("scene.handle_motion").handle_matrices(obj)[0], np.eye(4), 1e-5)
        size = point.empty_display_size
        self.assertGreater(size, 0.05, "one vertex has no size, but its empty is seen")
        mine = empty_at((0.0, 0.0, 4.0))
        self.api.add_handle_for(obj, mine)
        obj.arap.handle_size = 2.0
        self.assertAlmostEqual(point.empty_display_size, 2.0 * size, places=5)
        self.assertEqual(mine.empty_display_size, 1.0)

    def test_remove_takes_what_was_made_for_the_handle_and_nothing_else_uses(self):
        def nothing(_obj, _handle):
            pass

        def choose_others(obj, handle):
            obj.vertex_groups.new(name="Mine").add(TOP, 1.0, "REPLACE")
            handle.target, handle.vertex_group = bpy.data.objects["Control"], "Mine"

        def share(obj, handle):
            self.api.add_handle_for(bpy.data.objects["Second"], handle.target)
            self.api.add_stiffness_group(obj, "Head")

        mesh_object("Second")
        empty_at((0.0, 0.0, 4.0), "Control")
        for before, is_left in ((nothing, False), (choose_others, True), (share, True)):
            with self.subTest(before.__name__):
                obj = posable(before.__name__)
                target = obj.arap.handles[0].target.name
                before(obj, obj.arap.handles[0])
                self.api.remove_control(obj, obj.arap.handles[0].name)
                self.assertEqual((target in bpy.data.objects, "Head" in obj.vertex_groups), (is_left, is_left))
                self.assertEqual(len(obj.arap.handles), 0)
        self.assertIn("Control", bpy.data.objects)

    def test_the_image_that_a_made_empty_shows_is_the_artists(self):
        obj = posable()
        empty = obj.arap.handles[0].target
        empty.empty_display_type, empty.data = "IMAGE", bpy.data.images.new("Photo", 8, 8)
        twin = obj.copy()
        twin.data = obj.data.copy()
        self.scene.collection.objects.link(twin)
        bpy.context.view_layer.update()
        self.api.copy_handles(twin)
        self.assertEqual(twin.arap.handles[0].target.data, empty.data)
        for mesh in (twin, obj):
            self.api.remove_control(mesh, mesh.arap.handles[0].name)
            self.assertEqual(list(bpy.data.images.keys()), ["Photo"])

    def test_a_new_name_is_that_of_what_was_made_for_the_handle_too(self):
        obj = mesh_object()
        made, chosen = (
            obj.arap.controls[name]
            for name in [self.api.add_handle(obj, TOP, name="Top"), self.api.add_handle(obj, MIDDLE, name="Waist")]
        )
        mine = bpy.data.objects.new("Mine", None)
        self.scene.collection.objects.link(mine)
        chosen.target = mine
        obj.vertex_groups.new(name="Head")
        made.name = "Head"
        self.assertEqual((made.target.name, made.vertex_group), ("Head", "Head.001"))
        self.api.add_pin_group(obj, chosen.vertex_group)
        chosen = obj.arap.controls["Waist"]
        chosen.name = "Belly"
        self.assertEqual((mine.name, chosen.vertex_group), ("Mine", "Waist"), "the artist's, and used elsewhere")
        self.api.remove_control(obj, obj.arap.pins[0].name)
        twin = bpy.data.objects.new("Twin", obj.data)
        chosen.name = "Belly"
        self.assertEqual(chosen.vertex_group, "Waist", "another object has the mesh")
        bpy.data.objects.remove(twin)
        chosen.name = "Hips"
        self.assertEqual((mine.name, chosen.vertex_group, chosen.target), ("Mine", "Hips", mine))
        self.assertTrue(made.has_made_group and made.has_made_target and chosen.has_made_group)

    def test_names_of_handles_are_unique(self):
        obj = mesh_object()
        self.assertEqual([self.api.add_handle(obj, [i], name="Paw") for i in range(2)], ["Paw", "Paw.001"])


class RefusalTest(SceneTest):
    def test_targets_are_checked(self):
        obj = posable()
        rig, empty = armature(), empty_at((0.0, 0.0, 0.0))
        cases = [
            ((obj, ""), "'Tube' is the mesh itself; choose another object"),
            ((empty, "Tail"), "'Empty' is not an armature and has no bones; clear the bone"),
            ((rig, "Tail"), "armature 'Rig' has no bone 'Tail'; choose another bone"),
            ((None, ""), "it has no object; choose one or remove the handle"),
        ]
        for (target, bone), reason in cases:
            message = f"'Tube' cannot take the handle: {reason}"
            self.assert_error(ValueError, message, self.api.add_handle_for, obj, target, bone)
        message = "'Tube' has no objects to take as handles: select some besides the mesh"
        self.assert_error(ValueError, message, module("setup.handles").add_handles_for, obj, [])
        message = "'Tube' cannot take the handle: 'Tube' is the mesh itself; choose another object"
        self.assert_error(ValueError, message, module("setup.handles").add_handles_for, obj, [(empty, ""), (obj, "")])
        self.assertEqual((len(obj.arap.handles), len(obj.vertex_groups)), (1, 2), "all or none")

    def test_what_moves_the_mesh_already_is_no_handle(self):
        """Else it would move the mesh twice, whichever way it becomes a handle."""
        rig, obj = armature(), mesh_object()
        self.api.add_handle_for(obj, rig, "Lower")
        obj.vertex_groups.new(name="Upper")
        modifier = obj.modifiers.new("Skin", "ARMATURE")
        modifier.object = rig
        remedy = "already; remove it or switch it off, in viewports and renders"
        reason = f"modifier 'Skin' moves the mesh with bone 'Lower' {remedy}, or take a bone that does not deform"
        bpy.context.view_layer.objects.active = rig
        bpy.ops.object.mode_set(mode="POSE")
        bpy.ops.pose.select_all(action="SELECT")
        obj.select_set(True)
        for modifier.show_viewport in (True, False):  # off in viewports alone it still moves the render
            self.assertEqual(
                module("setup.controls").control_problem(obj, obj.arap.handles[0]),
                f"Handle 'Lower' of 'Tube': {reason}",
                "added before",
            )
            self.assert_error(ValueError, f"Handle 'Lower' of 'Tube': {reason}", self.api.solve, obj)
            message = f"'Tube' cannot take the handle: {reason}"
            self.assert_error(ValueError, message, self.api.add_handle_for, obj, rig, "Lower")
            self.assertRaises(RuntimeError, bpy.ops.arap.handle_add)
            self.assertEqual(len(obj.arap.handles), 1)
        bpy.ops.object.mode_set(mode="OBJECT")
        modifier.show_render = False
        self.assertEqual(module("setup.controls").control_problem(obj, obj.arap.handles[0]), "")
        modifier.show_render = True
        rig.data.bones["Upper"].use_deform = False
        obj.arap.handles[0].bone = "Upper"  # chosen in the list
        self.assertEqual(module("setup.controls").control_problem(obj, obj.arap.handles[0]), "")
        obj.arap.handles[0].bone = ""
        reason = f"modifier 'Skin' moves the mesh with 'Rig' {remedy}, or take a bone that does not deform"
        self.assertEqual(
            module("setup.controls").control_problem(obj, obj.arap.handles[0]), f"Handle 'Lower' of 'Tube': {reason}"
        )
        modifier.object, obj.parent, obj.parent_type = None, rig, "ARMATURE"
        obj.arap.handles[0].bone = "Lower"
        reason = "the parent (Armature Deform) moves the mesh with bone 'Lower' already; clear the parent, and keep the"
        self.assertEqual(
            module("setup.controls").control_problem(obj, obj.arap.handles[0]),
            f"Handle 'Lower' of 'Tube': {reason} place",
        )

    def test_a_bone_of_the_skin_that_does_not_move_this_mesh_is_a_handle(self):
        """A bone without a vertex group moves nothing, and the handle's own group does not become one."""
        rig, obj = armature(), mesh_object()
        obj.vertex_groups.new(name="Lower").add(list(range(len(obj.data.vertices))), 1.0, "REPLACE")
        modifier = obj.modifiers.new("Skin", "ARMATURE")
        modifier.object = rig
        self.api.add_pin(obj, BOTTOM)
        handle = obj.arap.controls[self.api.add_handle_for(obj, rig, "Upper", 2.1)]
        self.assertEqual((handle.name, handle.vertex_group), ("Upper", "Upper.001"))
        rig.pose.bones["Upper"].location.y = 1.0
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(obj), rest_positions(obj))
        self.api.solve(obj)
        obj.vertex_groups.new(name="Upper")
        self.assertRaises(ValueError, self.api.solve, obj)
        obj.vertex_groups.remove(obj.vertex_groups["Upper"])
        modifier.use_bone_envelopes = True
        self.assertRaises(ValueError, self.api.solve, obj)
        modifier.use_bone_envelopes = modifier.use_vertex_groups = False  # it moves nothing
        self.api.solve(obj)

    def test_what_the_mesh_is_hooked_to_is_no_handle(self):
        obj, empty = mesh_object(), empty_at((0.0, 0.0, 4.0), "Control")
        modifier = obj.modifiers.new("Hook", "HOOK")
        modifier.object = empty
        message = (
            "'Tube' cannot take the handle: modifier 'Hook' moves the mesh with 'Control' already; remove it or "
            "switch it off, in viewports and renders"
        )
        self.assert_error(ValueError, message, self.api.add_handle_for, obj, empty)
        modifier.show_viewport = modifier.show_render = False
        self.api.add_handle_for(obj, empty)

    def test_what_went_missing_is_named(self):
        obj = posable()
        self.assertEqual(module("setup.controls").control_problem(obj, obj.arap.handles[0]), "")

        def check(reason):
            message = f"Handle 'Head' of 'Tube': {reason}"
            self.assertEqual(module("setup.controls").control_problem(obj, obj.arap.handles[0]), message)
            self.assert_error(ValueError, message, self.api.solve, obj)

        target = obj.arap.handles[0].target
        target.hide_viewport = True
        check(
            "'Head' is disabled in viewports or excluded from the view layer, so it does not move; "
            "enable it, or hide it with the eye"
        )
        target.hide_viewport = False
        self.scene.collection.objects.unlink(target)  # what Delete does: the handle still has it
        check("its empty is not in the scene; press Copy Handles or remove the handle")
        self.scene.collection.objects.link(target)
        obj.vertex_groups.remove(obj.vertex_groups["Head"])
        check("there is no vertex group 'Head'; choose one or remove the handle")
        bpy.data.objects.remove(target)
        check("it has no object; choose one or remove the handle")
        obj.arap.handles[0].is_enabled = False
        obj.vertex_groups.remove(obj.vertex_groups["Feet"])
        message = "Pin 'Feet' of 'Tube': there is no vertex group 'Feet'; choose one or remove the pin"
        self.assert_error(ValueError, message, self.api.solve, obj)
        obj.arap.pins[0].is_enabled = False
        nothing = "Nothing holds or moves 'Tube': add a pin or a handle"
        self.assert_error(ValueError, nothing, self.api.solve, obj)
        obj.hide_viewport = True
        message = "'Tube' is disabled in viewports or excluded from the view layer: enable it, or hide it with the eye"
        self.assert_error(ValueError, f"{message}. {nothing}", self.api.solve, obj)

    def test_a_target_that_was_scaled_to_nothing_is_named_until_it_is_chosen_again(self):
        obj = mesh_object()
        empty = empty_at((0.0, 0.0, 4.0))
        empty.scale = (0.0, 1.0, 1.0)
        self.api.add_handle_for(obj, empty)
        message = "Handle 'Empty' of 'Tube': 'Empty' was scaled to nothing at rest; give it a scale and choose it again"
        self.assert_error(ValueError, message, self.api.solve, obj)
        empty.scale = (1.0, 1.0, 1.0)
        obj.arap.handles[0].target = empty
        self.api.solve(obj)

    def test_targets_of_an_excluded_collection_are_refused(self):
        obj = posable()
        target = obj.arap.handles[0].target
        collection = bpy.data.collections.new("Handles")
        self.scene.collection.children.link(collection)
        collection.objects.link(target)
        self.scene.collection.objects.unlink(target)
        self.api.solve(obj)
        layer = bpy.context.view_layer.layer_collection.children["Handles"]
        layer.hide_viewport = True
        self.assertEqual(module("setup.controls").control_problem(obj, obj.arap.handles[0]), "")
        for switch_off in (lambda: setattr(layer, "exclude", True), lambda: setattr(collection, "hide_viewport", True)):
            switch_off()
            self.assertIn(
                "is disabled in viewports or excluded",
                module("setup.controls").control_problem(obj, obj.arap.handles[0]),
            )
            layer.exclude = False

    def test_a_location_has_three_numbers(self):
        obj = mesh_object()
        message = "The location of handle 'Handle' has shape (2,): give x, y and z"
        self.assert_error(ValueError, message, self.api.add_handle, obj, TOP, location=(1.0, 2.0))
        self.assertEqual((len(obj.arap.handles), len(obj.vertex_groups)), (0, 0))


class OwnerTest(SceneTest):
    """The panel's mesh where something else is active, without a look at each redraw."""

    def setUp(self):
        super().setUp()
        self.owner = module("scene.ui_cache")

    def shown(self):
        return module("ui.checks").find_arap_object(bpy.context)

    def count_looks(self):
        """How many objects are asked whether the active one moves them."""
        plain, looks = self.owner.is_moved_by, []

        def is_moved_by(obj, asked):
            looks.append(obj)
            return plain(obj, asked)

        self.owner.is_moved_by = is_moved_by
        try:
            self.shown()
        finally:
            self.owner.is_moved_by = plain
        return len(looks)

    def test_the_meshes_with_handles_are_looked_at_once(self):
        meshes = [posable(f"Tube {i}") for i in range(20)]
        idle, control = empty_at((5.0, 0.0, 0.0), "Idle"), empty_at((0.0, 0.0, 4.0), "Control")
        self.api.add_handle_for(meshes[-1], control)
        for target in (control, idle):
            bpy.context.view_layer.objects.active = target
            bpy.context.view_layer.update()
            self.assertGreater(self.count_looks(), 1)
            self.assertLessEqual(self.count_looks(), 1)
        idle.location.x = 6.0
        bpy.context.view_layer.update()
        self.assertEqual(self.count_looks(), 0)

    def test_what_changes_the_answer_is_seen(self):
        obj = mesh_object()
        control = empty_at((0.0, 0.0, 4.0), "Control")
        bpy.context.view_layer.objects.active = control
        self.assertIsNone(self.shown())
        self.api.add_handle_for(obj, control)
        self.assertEqual(self.shown(), obj)
        self.api.remove_control(obj, obj.arap.handles[0].name)
        self.assertIsNone(self.shown())
        handle = obj.arap.controls.add()
        self.assertIsNone(self.shown())
        handle.target = control  # as the panel does
        self.assertEqual(self.shown(), obj)
        obj.name = "Pipe"
        self.assertEqual(self.shown(), obj)
        obj.arap.controls.clear()
        self.assertIsNone(self.shown())
        appended = obj.copy()
        appended.arap.controls.add().target = control
        self.assertIsNone(self.shown())
        self.scene.collection.objects.link(appended)
        bpy.context.view_layer.update()
        self.assertEqual(self.shown(), appended)
        bpy.data.objects.remove(appended)
        self.assertIsNone(self.shown())

    def test_a_handle_that_takes_the_name_of_another_object_is_found(self):
        obj = mesh_object()
        idle, control = empty_at((5.0, 0.0, 0.0), "Idle"), empty_at((0.0, 0.0, 4.0), "Control")
        self.api.add_handle_for(obj, control)
        bpy.context.view_layer.objects.active = idle
        self.assertIsNone(self.shown())
        idle.name, control.name = "Other", "Idle"
        bpy.context.view_layer.update()
        bpy.context.view_layer.objects.active = control
        self.assertEqual(self.shown(), obj)

    def test_an_undo_brings_a_handle_back(self):
        obj = mesh_object()
        self.api.add_handle_for(obj, empty_at((0.0, 0.0, 4.0), "Control"))
        bpy.ops.ed.undo_push(message="handle")
        self.api.remove_control(obj, obj.arap.handles[0].name)
        bpy.context.view_layer.objects.active = bpy.data.objects["Control"]
        bpy.ops.ed.undo_push(message="no handle")
        self.assertIsNone(self.shown())
        bpy.ops.ed.undo()
        bpy.context.view_layer.objects.active = bpy.data.objects["Control"]
        self.assertEqual(self.shown(), bpy.data.objects["Tube"])


class TakeOverTest(SceneTest):
    def test_choosing_while_the_mesh_is_flat_marks_the_handle(self):
        obj = posable()
        obj.scale.z = 0.0
        bpy.context.view_layer.update()
        handle = obj.arap.handles[0]
        target = empty_at((0.0, 0.0, 4.0), "Other")
        handle.target = target
        obj.scale.z = 1.0
        bpy.context.view_layer.update()
        message = (
            "Handle 'Head' of 'Tube': 'Tube' was scaled to nothing when 'Other' was chosen; "
            "give the mesh a scale and choose it again"
        )
        self.assertEqual(module("setup.controls").control_problem(obj, obj.arap.handles[0]), message)
        self.assert_error(ValueError, message, self.api.solve, obj)
        handle.target = target
        self.assertEqual(module("setup.controls").control_problem(obj, obj.arap.handles[0]), "")
        self.api.solve(obj)

    def test_a_disabled_handle_holds_what_is_shown_when_it_is_enabled(self):
        obj = solved()
        handle = obj.arap.controls[self.api.add_handle(obj, MIDDLE, name="Waist")]
        handle.is_enabled = False
        posed = key_positions(obj)
        handle.target = empty_at((1.0, 2.0, 3.0), "Other")
        self.assertNotEqual(handle.base_id, 0)
        handle.is_enabled = True
        self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, STAYS)

    def test_choosing_step_by_step_takes_over_in_the_end(self):
        """As in the panel: first the armature, then its bone; the group last; in Edit Mode too."""
        for mode in ("OBJECT", "EDIT"):
            obj = solved(f"In {mode}")
            posed = key_positions(obj)
            rig = armature()
            handle = obj.arap.handles[0]
            bpy.context.view_layer.objects.active = obj
            bpy.ops.object.mode_set(mode=mode)
            handle.vertex_group = ""
            handle.target = rig
            handle.bone = "Upper"
            handle.vertex_group = "Head"
            bpy.ops.object.mode_set(mode="OBJECT")
            self.api.solve(obj)
            self.assert_close(key_positions(obj), posed, 1e-3)
            rig.location.z += 0.5
            bpy.context.view_layer.update()
            self.api.solve(obj)
            self.assert_close(key_positions(obj)[TOP], posed[TOP] + np.array([0.0, 0.0, 0.5]), 1e-3)

    def test_an_unfinished_handle_keeps_what_it_has(self):
        obj = posable()
        handle = obj.arap.handles[0]
        target, rest = handle.target, handle.rest.copy()
        handle.target = None
        handle.bone = "Tail"
        self.assertEqual(handle.rest, rest)
        handle.bone = ""
        handle.target = target
        self.assert_close(handle.rest, rest, 1e-6)
