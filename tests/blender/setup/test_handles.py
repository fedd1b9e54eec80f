# SPDX-License-Identifier: GPL-3.0-or-later
"""Making, removing and resetting pins and handles."""

import numpy as np
from mathutils import Matrix, Vector
from support import (
    BOTTOM,
    MIDDLE,
    PLACED,
    TOP,
    FakeAct,
    SceneTest,
    bend,
    bpy,
    empty_at,
    in_world,
    key_positions,
    mesh_object,
    module,
    move,
    posable,
    rest_positions,
)


def armature(name="Rig"):
    """Two bones upwards, Lower to z = 2 and its child Upper to z = 4."""
    data = bpy.data.armatures.new(name)
    rig = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    lower = data.edit_bones.new("Lower")
    lower.head, lower.tail = (0.0, 0.0, 0.0), (0.0, 0.0, 2.0)
    upper = data.edit_bones.new("Upper")
    upper.head, upper.tail, upper.parent = (0.0, 0.0, 2.0), (0.0, 0.0, 4.0), lower
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    return rig


def group_of(obj, name):
    index = obj.vertex_groups[name].index
    return {v.index: g.weight for v in obj.data.vertices for g in v.groups if g.group == index}


def misfit(rest, shown):
    """How far ``shown`` is from the nearest place of ``rest`` as a rigid body."""
    rest, shown = rest - rest.mean(axis=0), shown - shown.mean(axis=0)
    u, _, vt = np.linalg.svd(shown.T @ rest)
    u[:, 2] *= np.sign(np.linalg.det(u @ vt))
    return np.linalg.norm(rest @ (u @ vt).T - shown, axis=1).max()


class PinTest(SceneTest):
    def test_add_pin_makes_a_group_of_weight_one(self):
        obj = mesh_object()
        pin = self.api.add_pin(obj, [5, 3, 3], name="Feet")
        self.assertEqual(pin.name, "Feet")
        self.assertTrue(pin.is_enabled)
        self.assertEqual(group_of(obj, "Feet"), {3: 1.0, 5: 1.0})

    def test_names_are_made_unique_and_never_shared(self):
        obj = mesh_object()
        first, second = self.api.add_pin(obj, [1]).name, self.api.add_pin(obj, [2]).name
        self.assertEqual((first, second), ("Pin", "Pin.001"))
        self.assertEqual(group_of(obj, first), {1: 1.0})

    def test_pinning_a_group_twice_gives_one_pin(self):
        obj = mesh_object()
        pin = self.api.add_pin(obj, [1], name="Feet")
        pin.is_enabled = False
        self.assertTrue(self.api.add_pin_group(obj, "Feet").is_enabled)
        self.assertEqual(len(obj.arap.pins), 1)

    def test_remove_takes_the_group_that_it_made_and_no_other(self):
        obj = mesh_object()
        obj.vertex_groups.new(name="Mine").add([1], 1.0, "REPLACE")
        self.api.add_pin_group(obj, "Mine")
        self.api.add_pin(obj, [2], name="Made")
        self.api.add_pin(obj, [3], name="Shared")
        self.api.add_stiffness_group(obj, "Shared")
        for _ in range(3):
            self.api.remove_pin(obj, 0)
        self.assertEqual(sorted(group.name for group in obj.vertex_groups), ["Mine", "Shared"])
        self.assertEqual(len(obj.arap.pins), 0)

    def test_a_group_that_a_modifier_uses_in_whatever_field_stays(self):
        def of_nodes(obj, group):
            tree = bpy.data.node_groups.new("Nodes", "GeometryNodeTree")
            if hasattr(tree, "interface"):  # 4.0
                tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
                key = tree.interface.new_socket("Field", in_out="INPUT", socket_type="NodeSocketFloat").identifier
            else:
                tree.inputs.new("NodeSocketGeometry", "Geometry")
                key = tree.inputs.new("NodeSocketFloat", "Field").identifier
            modifier = obj.modifiers.new("Nodes", "NODES")
            modifier.node_group = tree
            if hasattr(modifier, "properties"):  # 5.2
                getattr(modifier.properties.inputs, key).attribute_name = group
            else:
                modifier[f"{key}_attribute_name"] = group

        def of_particles(obj, group):
            obj.modifiers.new("Hair", "PARTICLE_SYSTEM").particle_system.vertex_group_density = group

        def of_cloth(obj, group):
            obj.modifiers.new("Cloth", "CLOTH").settings.vertex_group_mass = group

        def of_rim(obj, group):
            obj.modifiers.new("Solidify", "SOLIDIFY").rim_vertex_group = group

        def of_mix(obj, group):
            obj.modifiers.new("Mix", "VERTEX_WEIGHT_MIX").vertex_group_b = group

        def of_lattice(obj, group):
            obj.modifiers.new("Lattice", "LATTICE").vertex_group = group

        for use in (of_nodes, of_particles, of_cloth, of_rim, of_mix, of_lattice):
            with self.subTest(use.__name__):
                obj = mesh_object()
                self.api.add_pin(obj, [1], name="Used")
                self.api.add_pin(obj, [2], name="Lone")
                use(obj, "Used")
                for _ in range(2):
                    self.api.remove_pin(obj, 0)
                self.assertEqual([group.name for group in obj.vertex_groups], ["Used"])

    def test_disabled_pins_and_handles_do_nothing(self):
        obj = posable()
        self.api.add_pin(obj, MIDDLE, name="Waist")
        obj.arap.pins["Waist"].is_enabled = False
        bend(obj)
        self.api.solve(obj)
        moved = np.abs(key_positions(obj) - rest_positions(obj)).max(axis=1)
        self.assertGreater(moved[MIDDLE].min(), 0.05)
        obj.arap.handles[0].is_enabled = False
        self.api.solve(obj)
        self.assert_close(key_positions(obj), rest_positions(obj), 4e-6)


class HandleTest(SceneTest):
    def test_the_empty_stands_at_the_centroid_sized_to_the_group_and_follows_the_object(self):
        obj = mesh_object(matrix=PLACED)
        handle = self.api.add_handle(obj, TOP, name="Head")
        bpy.context.view_layer.update()
        points = in_world(obj, rest_positions(obj)[TOP])
        self.assert_close(handle.target.matrix_world.translation, points.mean(axis=0), 1e-5)
        self.assert_close(np.array(handle.target.matrix_world)[:3, :3], np.eye(3), 1e-5)
        radius = np.linalg.norm(points - points.mean(axis=0), axis=1).max()
        self.assertAlmostEqual(handle.target.empty_display_size, radius, places=5)
        self.assertIs(handle.target.parent, obj)
        self.assertEqual(group_of(obj, handle.vertex_group), dict.fromkeys(TOP, 1.0))
        self.assertEqual(list(handle.target.users_collection), list(obj.users_collection))

    def test_the_empty_stands_where_it_is_asked_to(self):
        obj = mesh_object(matrix=PLACED)
        handle = self.api.add_handle(obj, TOP, location=(1.0, 2.0, 3.0))
        bpy.context.view_layer.update()
        self.assert_close(handle.target.matrix_world.translation, (1.0, 2.0, 3.0))
        self.assert_close(module("scene.handle_motion").handle_matrices(obj)[0], np.eye(4), 1e-5)

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
            handle = self.api.add_handle(obj, TOP)
            self.assertEqual(list(handle.target.users_collection), [expected])
            bpy.context.view_layer.update()
            self.assertEqual(module("setup.handles").handle_problem(obj, len(obj.arap.handles) - 1), "")
            if expected == enabled:
                enabled.objects.unlink(obj)

    def test_a_handle_of_one_vertex_has_a_size_one_can_see(self):
        handle = self.api.add_handle(mesh_object(), [7])
        self.assertGreater(handle.target.empty_display_size, 0.05)

    def test_display_settings_change_every_empty(self):
        obj = posable()
        target = obj.arap.handles[0].target
        obj.arap.handle_shape = "CUBE"
        obj.arap.handle_in_front = False
        obj.arap.handle_color = (0.1, 0.2, 0.3, 1.0)
        before = target.empty_display_size
        obj.arap.handle_size = 2.0
        self.assertEqual(target.empty_display_type, "CUBE")
        self.assertFalse(target.show_in_front)
        self.assert_close(target.color, (0.1, 0.2, 0.3, 1.0))
        self.assertAlmostEqual(target.empty_display_size, 2.0 * before, places=5)

    def test_adding_a_handle_to_a_posed_mesh_never_moves_it(self):
        """The empty appears where the pose has taken the group, turned as the group is turned."""
        for matrix in (Matrix(), PLACED):
            with self.subTest(matrix):
                obj = posable(matrix=matrix)
                bend(obj)
                self.api.solve(obj)
                posed = key_positions(obj)
                handle = self.api.add_handle(obj, MIDDLE, name="Waist")
                bpy.context.view_layer.update()
                self.assert_close(key_positions(obj), posed, 0.0)
                shown = in_world(obj, posed[MIDDLE])
                self.assert_close(handle.target.matrix_world.translation, shown.mean(axis=0), 1e-4)
                # At rest it stands at the centroid at rest: that is where a reset takes it.
                at_rest = np.array(obj.matrix_world) @ np.array(handle.rest)
                self.assert_close(at_rest[:3, 3], in_world(obj, rest_positions(obj)[MIDDLE]).mean(axis=0), 1e-4)
                # The ring was bent out of shape; solved again it is as it was but for that.
                self.api.solve(obj)
                out_of_shape = misfit(in_world(obj, rest_positions(obj)[MIDDLE]), shown)
                moved = np.abs(in_world(obj, key_positions(obj)) - in_world(obj, posed)).max()
                self.assertLess(moved, 1.5 * out_of_shape)
                self.assertGreater(np.abs(posed - rest_positions(obj)).max(), 1.0)

    def test_a_new_target_takes_over_where_it_stands(self):
        obj = posable()
        bend(obj)
        self.api.solve(obj)
        posed = key_positions(obj)
        other = empty_at((7.0, 8.0, 9.0))
        other.rotation_euler = (1.0, 0.0, 0.0)
        bpy.context.view_layer.update()
        obj.arap.handles[0].target = other  # as the panel does
        self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, 1e-3)
        move(other, (0.0, 0.0, 0.5))
        self.api.solve(obj)
        self.assert_close(key_positions(obj)[TOP], posed[TOP] + np.array([0.0, 0.0, 0.5]), 1e-3)

    def test_what_the_artist_has_chosen_in_the_panel_stays_when_the_handle_goes(self):
        obj = posable()
        control = empty_at((0.0, 0.0, 4.0), "Control")
        shape = control.empty_display_type
        obj.vertex_groups.new(name="Mine").add(TOP, 1.0, "REPLACE")
        handle = obj.arap.handles[0]
        handle.target, handle.vertex_group = control, "Mine"
        obj.arap.handle_shape = "CUBE"
        self.assertEqual(control.empty_display_type, shape)
        self.api.remove_handle(obj, 0)
        self.assertIn("Control", bpy.data.objects)
        self.assertIn("Mine", obj.vertex_groups)

    def test_what_a_handle_made_goes_with_it_also_where_a_script_gives_it_the_same_again(self):
        obj = posable()
        handle = obj.arap.handles[0]
        module("setup.handles").set_handle_target(obj, 0, handle.target)
        module("setup.handles").set_handle_group(obj, 0, handle.vertex_group)
        self.api.remove_handle(obj, 0)
        self.assertNotIn("Head", bpy.data.objects)
        self.assertNotIn("Head", obj.vertex_groups)

    def test_a_new_group_does_not_move_the_mesh(self):
        obj = posable()
        bend(obj)
        self.api.solve(obj)
        posed = key_positions(obj)
        obj.vertex_groups.new(name="Other").add(TOP, 1.0, "REPLACE")
        module("setup.handles").set_handle_group(obj, 0, "Other")
        self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, 1e-3)

    def test_handles_for_empties_take_the_vertices_around_them_or_the_nearest(self):
        obj = mesh_object(matrix=PLACED)
        world = in_world(obj, rest_positions(obj))
        near, far = empty_at(world[TOP].mean(axis=0), "Near"), empty_at(world[BOTTOM[0]] + 30.0, "Far")
        radius = 1.5
        handles = module("setup.handles").add_handles_for(obj, [(near, ""), (far, "")], radius=radius)
        centre = np.array(near.matrix_world.translation)
        within = np.flatnonzero(np.linalg.norm(world - centre, axis=1) <= radius)
        self.assertGreater(len(within), 4)
        self.assertEqual(sorted(group_of(obj, handles[0].vertex_group)), within.tolist())
        nearest = np.linalg.norm(world - np.array(far.matrix_world.translation), axis=1).argmin()
        self.assertEqual(list(group_of(obj, handles[1].vertex_group)), [nearest])
        self.assertEqual([handle.name for handle in handles], ["Near", "Far"])
        self.assertIs(handles[0].target, near)
        self.assertIsNone(near.parent)
        self.assert_close(module("scene.handle_motion").handle_matrices(obj), np.tile(np.eye(4), (2, 1, 1)), 1e-5)

    def test_of_what_is_selected_empties_and_bones_become_handles_and_nothing_else(self):
        obj = mesh_object()
        empty_at((0.0, 0.0, 4.0), "Control")
        for name, data in (("Sun", bpy.data.lights.new("Sun", "SUN")), ("Eye", bpy.data.cameras.new("Eye"))):
            self.scene.collection.objects.link(bpy.data.objects.new(name, data))
        bpy.ops.object.select_all(action="SELECT")
        bpy.context.view_layer.objects.active = obj
        self.assertEqual(bpy.ops.arap.handle_add_from_empties(), {"FINISHED"})
        self.assertEqual([handle.target.name for handle in obj.arap.handles], ["Control"])
        self.assertFalse(bpy.ops.arap.handle_add_from_empties.poll())
        rig = armature()
        self.api.add_handle_for(obj, rig, bone="Lower")
        bpy.ops.object.mode_set(mode="POSE")
        bpy.ops.pose.select_all(action="SELECT")
        self.assertEqual(bpy.ops.arap.handle_add_from_empties(), {"FINISHED"})
        self.assertEqual([handle.bone for handle in obj.arap.handles], ["", "Lower", "Upper"])

    def test_without_a_radius_an_empty_takes_the_nearest_vertex_of_the_pose(self):
        obj = posable()
        move(obj.arap.handles[0].target, (0.0, 3.0, -2.0))
        self.api.solve(obj)
        place = key_positions(obj)[TOP[0]]
        handle = self.api.add_handle_for(obj, empty_at(place))
        self.assertEqual(list(group_of(obj, handle.vertex_group)), [TOP[0]])

    def test_bones_are_handles(self):
        obj = mesh_object()
        rig = armature()
        self.api.add_pin(obj, BOTTOM)
        handle = self.api.add_handle_for(obj, rig, bone="Upper", radius=0.52)
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
        head = self.api.add_handle(obj, TOP)
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

    def test_reset_names_the_handles_that_something_holds(self):
        obj = posable()
        holder = empty_at((5.0, 5.0, 5.0))
        target = obj.arap.handles[0].target
        target.constraints.new("COPY_LOCATION").target = holder
        self.assertEqual(self.api.reset_handles(obj), ["Head"])

    def test_remove_takes_the_group_and_the_empty_that_it_made(self):
        obj = posable()
        self.api.remove_handle(obj, 0)
        self.assertIsNone(bpy.data.objects.get("Head"))
        self.assertNotIn("Head", obj.vertex_groups)
        self.assertEqual(len(obj.arap.handles), 0)

    def test_remove_leaves_what_others_use(self):
        obj, other = posable("First"), mesh_object("Second")
        target = obj.arap.handles[0].target
        self.api.add_handle_for(other, target)
        self.api.add_stiffness_group(obj, "Head")
        self.api.remove_handle(obj, 0)
        self.assertIs(other.arap.handles[0].target, target)
        self.assertIn("Head", obj.vertex_groups)

    def test_remove_leaves_a_users_own_empty(self):
        obj = mesh_object()
        mine = empty_at((0.0, 0.0, 4.0), "Mine")
        self.api.add_handle_for(obj, mine)
        self.api.remove_handle(obj, 0)
        self.assertIs(bpy.data.objects.get("Mine"), mine)

    def test_names_of_handles_are_unique(self):
        obj = mesh_object()
        names = [self.api.add_handle(obj, [i], name="Paw").name for i in range(3)]
        self.assertEqual(names, ["Paw", "Paw.001", "Paw.002"])


class RefusalTest(SceneTest):
    def test_vertices_are_checked(self):
        obj = mesh_object()
        n = len(obj.data.vertices)
        for function in (self.api.add_pin, self.api.add_handle):
            self.assert_error(ValueError, "No vertices of 'Tube' were given: select some", function, obj, [])
            self.assert_error(
                ValueError, f"'Tube' has no vertex {n}: its vertices are 0 to {n - 1}", function, obj, [0, n]
            )
            self.assert_error(
                ValueError, f"'Tube' has no vertex -1: its vertices are 0 to {n - 1}", function, obj, [-1]
            )
            self.assert_error(ValueError, "Vertices of 'Tube' must be whole numbers, not float64", function, obj, [0.5])
        self.assertEqual((len(obj.vertex_groups), len(obj.arap.pins), len(obj.arap.handles)), (0, 0, 0))

    def test_lists_and_groups_are_checked(self):
        obj = posable()
        self.assert_error(ValueError, "'Tube' has no pin 1: it has 1", self.api.remove_pin, obj, 1)
        self.assert_error(ValueError, "'Tube' has no handle 4: it has 1", self.api.remove_handle, obj, 4)
        message = "'Tube' has no vertex group 'Tail': choose one of its groups"
        self.assert_error(ValueError, message, self.api.add_pin_group, obj, "Tail")
        self.assert_error(ValueError, message, module("setup.handles").set_handle_group, obj, 0, "Tail")

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
            message = f"Handle 'Head' of 'Tube' cannot take it: {reason}"
            self.assert_error(ValueError, message, module("setup.handles").set_handle_target, obj, 0, target, bone)
        message = "'Tube' has no objects to take as handles: select some besides the mesh"
        self.assert_error(ValueError, message, module("setup.handles").add_handles_for, obj, [])
        message = "'Tube' cannot take the handle: 'Tube' is the mesh itself; choose another object"
        self.assert_error(ValueError, message, module("setup.handles").add_handles_for, obj, [(empty, ""), (obj, "")])
        self.assertEqual((len(obj.arap.handles), len(obj.vertex_groups)), (1, 2), "all or none")

    def test_what_went_missing_is_named(self):
        obj = posable()
        self.assertEqual(module("setup.handles").handle_problem(obj, 0), "")

        def check(reason):
            message = f"Handle 'Head' of 'Tube': {reason}"
            self.assertEqual(module("setup.handles").handle_problem(obj, 0), message)
            self.assert_error(ValueError, message, self.api.solve, obj)

        target = obj.arap.handles[0].target
        target.hide_viewport = True
        check(
            "'Head' is disabled in viewports or excluded from the view layer, so it does not move; "
            "enable it, or hide it with the eye"
        )
        target.hide_viewport = False
        self.scene.collection.objects.unlink(target)  # what Delete does: the handle still has it
        check("'Head' is not in the scene any more; choose another object or remove the handle")
        self.scene.collection.objects.link(target)
        obj.vertex_groups.remove(obj.vertex_groups["Head"])
        check("there is no vertex group 'Head'; choose one or remove the handle")
        bpy.data.objects.remove(target)
        check("it has no object; choose one or remove the handle")
        obj.arap.handles[0].is_enabled = False
        obj.vertex_groups.remove(obj.vertex_groups["Feet"])
        message = "Pin 'Feet' of 'Tube': there is no vertex group of that name; choose one or remove the pin"
        self.assert_error(ValueError, message, self.api.solve, obj)
        obj.arap.pins[0].is_enabled = False
        self.assert_error(ValueError, "Nothing holds or moves 'Tube': add a pin or a handle", self.api.solve, obj)

    def test_a_target_that_was_scaled_to_nothing_is_named_until_it_is_chosen_again(self):
        obj = mesh_object()
        empty = empty_at((0.0, 0.0, 4.0))
        empty.scale = (0.0, 1.0, 1.0)
        self.api.add_handle_for(obj, empty)
        message = "Handle 'Empty' of 'Tube': 'Empty' was scaled to nothing at rest; give it a scale and choose it again"
        self.assert_error(ValueError, message, self.api.solve, obj)
        empty.scale = (1.0, 1.0, 1.0)
        module("setup.handles").set_handle_target(obj, 0, empty)
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
        self.assertEqual(module("setup.handles").handle_problem(obj, 0), "")
        for switch_off in (lambda: setattr(layer, "exclude", True), lambda: setattr(collection, "hide_viewport", True)):
            switch_off()
            self.assertIn("is disabled in viewports or excluded", module("setup.handles").handle_problem(obj, 0))
            layer.exclude = False

    def test_a_disabled_mesh_is_refused(self):
        obj = posable()
        obj.hide_viewport = True
        message = "'Tube' is disabled in viewports or excluded from the view layer: enable it, or hide it with the eye"
        self.assert_error(ValueError, message, self.api.solve, obj)

    def test_what_is_no_mesh_is_refused(self):
        for function in (self.api.add_pin, self.api.add_handle):
            self.assert_error(
                ValueError, "'Empty' is not a mesh: choose a mesh object", function, empty_at(Vector()), [0]
            )
            bpy.data.objects.remove(bpy.data.objects["Empty"])
        self.assert_error(ValueError, "'Nothing' is not a mesh: choose a mesh object", self.api.solve, None)

    def test_a_group_without_weights_is_refused(self):
        obj = posable()
        obj.vertex_groups["Head"].remove(TOP)
        message = (
            "Handle 'Head' of 'Tube': vertex group 'Head' has no weights; assign vertices to it or remove the handle"
        )
        self.assert_error(ValueError, message, self.api.solve, obj)
        obj.arap.handles[0].is_enabled = False
        self.api.solve(obj)

    def test_a_location_has_three_numbers(self):
        obj = mesh_object()
        message = "The location of handle 'Handle' has shape (2,): give x, y and z"
        self.assert_error(ValueError, message, self.api.add_handle, obj, TOP, location=(1.0, 2.0))
        self.assertEqual((len(obj.arap.handles), len(obj.vertex_groups)), (0, 0))

    def test_a_mesh_that_moves_the_posed_one_shows_its_panel(self):
        obj, mover = posable(), mesh_object("Mover")
        module("setup.handles").set_handle_target(obj, 0, mover)
        bpy.context.view_layer.objects.active = mover
        common = module("ui.checks")
        self.assertEqual(common.find_posed_object(bpy.context), mover)
        sessions = module("core.sessions")
        act = FakeAct("it is posed")
        sessions.claim(obj.name, act)
        self.addCleanup(sessions.release, obj.name, act)
        self.assertEqual(common.find_posed_object(bpy.context), obj)
        self.api.add_pin(mover, BOTTOM)
        self.assertEqual(common.find_posed_object(bpy.context), mover)


class OwnerTest(SceneTest):
    """The panel's mesh where something else is active, without a look at all objects at each redraw."""

    def setUp(self):
        super().setUp()
        self.owner = module("scene.owners")

    def shown(self):
        return module("ui.checks").find_posed_object(bpy.context)

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

    def test_all_objects_are_looked_at_once(self):
        meshes = [mesh_object(f"Tube {i}") for i in range(20)]
        idle, control = empty_at((5.0, 0.0, 0.0), "Idle"), empty_at((0.0, 0.0, 4.0), "Control")
        self.api.add_handle_for(meshes[-1], control)
        for target in (control, idle):
            bpy.context.view_layer.objects.active = target
            bpy.context.view_layer.update()
            self.assertGreaterEqual(self.count_looks(), 20)
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
        self.api.remove_handle(obj, 0)
        self.assertIsNone(self.shown())
        handle = obj.arap.handles.add()
        self.assertIsNone(self.shown())
        handle.target = control  # as the panel does
        self.assertEqual(self.shown(), obj)
        obj.name = "Pipe"
        self.assertEqual(self.shown(), obj)
        obj.arap.handles.clear()
        self.assertIsNone(self.shown())
        appended = obj.copy()
        appended.arap.handles.add().target = control
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
        self.api.remove_handle(obj, 0)
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
        self.assertEqual(module("setup.handles").handle_problem(obj, 0), message)
        self.assert_error(ValueError, message, self.api.solve, obj)
        handle.target = target
        self.assertEqual(module("setup.handles").handle_problem(obj, 0), "")
        self.api.solve(obj)

    def test_choosing_step_by_step_takes_over_in_the_end(self):
        """As in the panel: first the armature, then its bone; the group last; in Edit Mode too."""
        for mode in ("OBJECT", "EDIT"):
            obj = posable(f"In {mode}")
            bend(obj)
            self.api.solve(obj)
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
