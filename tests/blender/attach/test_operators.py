# SPDX-License-Identifier: GPL-3.0-or-later
"""Attach: the buttons."""

import numpy as np
from clothes import AttachTest, eye, new_object, sleeve
from support import bpy, module
from tubes import Matrix, posable


class OperatorTest(AttachTest):
    def select(self, host, *others):
        for obj in bpy.context.view_layer.objects:
            obj.select_set(obj in (host, *others))
        bpy.context.view_layer.objects.active = host

    def test_the_selected_objects_are_attached_to_the_active_one(self):
        host, target = posable(), sleeve()
        eye()  # it is near, but not selected
        self.select(host, target, host.arap.handles[0].target)
        self.assertEqual(bpy.ops.arap.attach(), {"FINISHED"})
        self.assertEqual([attachment.object for attachment in host.arap.attachments], [target])
        self.assertEqual(bpy.ops.arap.detach(), {"FINISHED"})
        self.assertEqual(len(host.arap.attachments), 0)
        why = module("attach.operators").why_nothing_attached
        self.assertEqual(why(bpy.context), "Nothing is attached to this mesh")

    def test_detach_on_an_attached_mesh_detaches_it(self):
        host, objects = posable(), [sleeve(), eye()]
        self.api.attach(host, objects)
        self.select(objects[0])
        self.assertEqual(bpy.ops.arap.detach(), {"FINISHED"})
        self.assertEqual([attachment.object for attachment in host.arap.attachments], objects[1:])

    def test_children_and_what_is_near_are_found(self):
        host, clothes, ball = posable(), sleeve(), eye()
        hat = new_object("Hat", eye().data.copy(), Matrix.Translation((0.0, 0.0, 9.0)))
        hat.parent = host
        bpy.data.objects.remove(bpy.data.objects["Eye.001"])
        button = new_object("Button", ball.data.copy(), ball.matrix_world)
        button.arap.attached_to.host = host  # as a copy of an attached object has it
        new_object("Far", hat.data.copy(), Matrix.Translation((3.0, 0.0, 2.0)))
        nowhere = new_object("Nowhere", ball.data.copy(), ball.matrix_world)
        nowhere.data.vertices[1].co.x = np.nan
        floor = bpy.data.meshes.new("Floor")
        floor.from_pydata([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], [], [(0, 1, 2, 3)])
        new_object("Floor", floor)
        self.select(host)
        bpy.context.view_layer.update()
        self.assertEqual(bpy.ops.arap.attach(), {"FINISHED"})
        self.assertEqual({attachment.object for attachment in host.arap.attachments}, {clothes, ball, hat, button})
        found = [attachment.object for attachment in host.arap.attachments]
        text = module("attach.operators").attached_text(host, found)
        self.assertRegex(text, r"^Attached to 'Tube': 4 objects \(\w+, \w+, \w+ and 1 more\)$")
        with self.assertRaisesRegex(RuntimeError, "No other mesh is near 'Tube'"):
            bpy.ops.arap.attach()
