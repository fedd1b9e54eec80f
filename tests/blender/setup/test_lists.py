# SPDX-License-Identifier: GPL-3.0-or-later
"""The lists of pins and of stiffness: entries and their vertex groups, added, shared and removed; what is refused."""

import numpy as np
from looks import group_of, key_positions, rest_positions
from mathutils import Vector
from support import SceneTest, bpy
from tubes import MIDDLE, bend, empty_at, mesh_object, posable


class ListTest(SceneTest):
    """Each fact for pins and for stiffness: they share the code."""

    def lists(self):
        """A new mesh, its list, and the functions of the list: add vertices, add a group, remove."""
        api = self.api
        for kind, *functions in (
            ("controls", api.add_pin, api.add_pin_group, api.remove_control),
            ("stiffness", api.add_stiffness, api.add_stiffness_group, api.remove_stiffness),
        ):
            obj = mesh_object(kind)
            with self.subTest(kind):
                yield obj, getattr(obj.arap, kind), *functions

    def test_add_makes_a_group_of_weight_one_with_a_free_name(self):
        for obj, items, add, _, _ in self.lists():
            for vertices, name in (([5, 3, 3], "Feet"), ([2], "Feet.001")):
                self.assertEqual(add(obj, vertices, name="Feet"), name)
                self.assertTrue(items[name].is_enabled)
                self.assertEqual(group_of(obj, name), dict.fromkeys(vertices, 1.0))
            self.assertEqual(len(items), 2)

    def test_a_group_has_one_entry(self):
        for obj, items, add, add_group, _ in self.lists():
            items[add(obj, [1], name="Feet")].is_enabled = False
            self.assertTrue(items[add_group(obj, "Feet")].is_enabled)
            self.assertEqual([entry.name for entry in items], ["Feet"])

    def test_remove_takes_only_the_groups_that_were_made_and_are_not_used(self):
        for obj, items, add, add_group, remove in self.lists():
            obj.vertex_groups.new(name="Mine").add([1], 1.0, "REPLACE")
            add_group(obj, "Mine")
            add(obj, [2], name="Made")
            add(obj, [3], name="Shared")
            self.api.add_handle_for(obj, empty_at((0.0, 0.0, 0.0)))
            obj.arap.handles[0].vertex_group = "Shared"
            entry = items[add(obj, [4], name="Other")]
            setattr(entry, "vertex_group" if hasattr(entry, "vertex_group") else "name", "Mine")  # in the panel
            for _ in range(len(items)):
                remove(obj, items[0].name)
            names = {group.name for group in obj.vertex_groups}
            self.assertTrue({"Mine", "Shared", "Other"} <= names and "Made" not in names)
            self.assertEqual(obj.arap.active_stiffness_index + obj.arap.chosen_control_index, 0)
            bpy.data.objects.remove(bpy.data.objects["Empty"])

    def test_a_group_stays_if_any_field_of_a_modifier_uses_it(self):
        def of_nodes(obj, group):
            tree = bpy.data.node_groups.new("Nodes", "GeometryNodeTree")
            tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
            key = tree.interface.new_socket("Field", in_out="INPUT", socket_type="NodeSocketFloat").identifier
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

        def of_field(kind, field):
            return lambda obj, group: setattr(obj.modifiers.new(kind, kind), field, group)

        plain = (("SOLIDIFY", "rim_vertex_group"), ("VERTEX_WEIGHT_MIX", "vertex_group_b"), ("LATTICE", "vertex_group"))
        for use in (of_nodes, of_particles, of_cloth, *(of_field(*each) for each in plain)):
            obj = mesh_object()
            self.api.add_pin(obj, [1], name="Used")
            self.api.add_pin(obj, [2], name="Lone")
            use(obj, "Used")
            for _ in range(2):
                self.api.remove_control(obj, obj.arap.pins[0].name)
            self.assertEqual([group.name for group in obj.vertex_groups], ["Used"])

    def test_disabled_pins_and_handles_do_nothing(self):
        obj = posable()
        obj.arap.controls[self.api.add_pin(obj, MIDDLE, name="Waist")].is_enabled = False
        bend(obj)
        self.api.solve(obj)
        self.assertGreater(np.abs(key_positions(obj) - rest_positions(obj)).max(axis=1)[MIDDLE].min(), 0.05)
        obj.arap.handles[0].is_enabled = False
        self.api.solve(obj)
        self.assert_close(key_positions(obj), rest_positions(obj), 4e-6)


class RefusalTest(SceneTest):
    def test_vertices_and_objects_are_checked(self):
        obj, empty = mesh_object(), empty_at(Vector())
        n = len(obj.data.vertices)
        for wrong, vertices, message in (
            (obj, [], "No vertices of 'Tube' were given: select some"),
            (obj, [0, n], f"'Tube' has no vertex {n}: its vertices are 0 to {n - 1}"),
            (obj, [-1], f"'Tube' has no vertex -1: its vertices are 0 to {n - 1}"),
            (obj, [0.5], "Vertices of 'Tube' must be whole numbers, not float64"),
            (empty, [0], "'Empty' is not a mesh: choose a mesh object"),
        ):
            for add in (self.api.add_pin, self.api.add_handle, self.api.add_stiffness, self.api.add_rigid):
                self.assert_error(ValueError, message, add, wrong, vertices)
        self.assertEqual((len(obj.vertex_groups), len(obj.arap.pins), len(obj.arap.handles)), (0, 0, 0))
        self.assert_error(ValueError, "'Nothing' is not a mesh: choose a mesh object", self.api.solve, None)

    def test_entries_and_groups_are_checked(self):
        obj = posable()
        message = "'Tube' has no pin, handle or bone 'Tail': it has 'Feet', 'Head'"
        self.assert_error(ValueError, message, self.api.remove_control, obj, "Tail")
        message = "'Tube' has no stiffness of a vertex group 'Tail'"
        self.assert_error(ValueError, message, self.api.remove_stiffness, obj, "Tail")
        message = "'Tube' has no vertex group 'Tail': choose one of its groups"
        for function, arguments in (
            (self.api.add_pin_group, ("Tail",)),
            (self.api.add_stiffness_group, ("Tail",)),
            (self.api.soften_group, ("Tail", 1.0)),
        ):
            self.assert_error(ValueError, message, function, obj, *arguments)
        for factor in (0.5, 101.0, float("nan")):
            message = f"factor = {factor}, must be 1 to 100"
            self.assert_error(ValueError, message, self.api.add_stiffness, obj, MIDDLE, "Belly", factor)
