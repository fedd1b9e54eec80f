# SPDX-License-Identifier: GPL-3.0-or-later
"""Carry Along: the buttons."""

import numpy as np
from clothes import CarryTest, eye, new_object, sleeve
from support import bpy, module
from tubes import Matrix, posable


class OperatorTest(CarryTest):
    def select(self, body, *others):
        for obj in bpy.context.view_layer.objects:
            obj.select_set(obj in (body, *others))
        bpy.context.view_layer.objects.active = body

    def test_the_selected_objects_go_along_with_the_active_one(self):
        body, target = posable(), sleeve()
        self.select(body)
        self.assertFalse(bpy.ops.arap.carry_along.poll())
        why = module("carry.operators").why_nothing_selected
        self.assertEqual(
            why(bpy.context), "Select clothes, hair or eyes, then Shift-click the mesh that they go along with"
        )
        self.select(body, target, body.arap.handles[0].target)
        self.assertEqual(bpy.ops.arap.carry_along(), {"FINISHED"})
        self.assertEqual([follower.target for follower in body.arap.followers], [target])
        self.assertEqual(bpy.ops.arap.carry_remove(), {"FINISHED"})
        self.assertEqual(
            module("carry.operators").why_no_follower(bpy.context), "Nothing goes along yet: the list is empty"
        )

    def test_children_and_what_is_near_are_found(self):
        body, clothes, ball = posable(), sleeve(), eye()
        hat = new_object("Hat", eye().data.copy(), Matrix.Translation((0.0, 0.0, 9.0)))
        hat.parent = body
        bpy.data.objects.remove(bpy.data.objects["Eye.001"])
        button = new_object("Button", ball.data.copy(), ball.matrix_world)
        button.arap.carried.body = body  # as a copy of a follower has it
        new_object("Far", hat.data.copy(), Matrix.Translation((3.0, 0.0, 2.0)))
        nowhere = new_object("Nowhere", ball.data.copy(), ball.matrix_world)
        nowhere.data.vertices[1].co.x = np.nan
        floor = bpy.data.meshes.new("Floor")
        floor.from_pydata([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], [], [(0, 1, 2, 3)])
        new_object("Floor", floor)
        self.select(body)
        bpy.context.view_layer.update()
        self.assertEqual(bpy.ops.arap.carry_near(), {"FINISHED"})
        self.assertEqual({follower.target for follower in body.arap.followers}, {clothes, ball, hat, button})
        found = [follower.target for follower in body.arap.followers]
        text = module("carry.operators").added_text(body, found)
        self.assertRegex(text, r"^Along with 'Tube': 4 objects \(\w+, \w+, \w+ and 1 more\)$")
        with self.assertRaisesRegex(RuntimeError, "No other mesh is near 'Tube'"):
            bpy.ops.arap.carry_near()
