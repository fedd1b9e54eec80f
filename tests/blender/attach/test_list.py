# SPDX-License-Identifier: GPL-3.0-or-later
"""Attach: who may follow whom, and what is told if one cannot."""

import numpy as np
from clothes import AttachTest, eye, new_object, sleeve
from looks import edge_lengths, key_names, rest_positions, shown_positions
from support import bpy, linked_back, module
from tubes import bend, mesh_object, posable, solved


class ListTest(AttachTest):
    def test_remove_and_the_tick_take_back_what_was_made(self):
        host, target = solved(), sleeve()
        self.api.attach(host, [target])
        host.arap.attachments[0].is_enabled = False
        self.assertEqual(key_names(target), ["Basis"])
        self.assert_at_rest(target)
        host.arap.attachments[0].is_enabled = True
        self.assert_follows(host, target)
        self.api.detach(host, target)
        self.assertEqual((key_names(target), len(host.arap.attachments)), ([], 0))
        self.assert_error(ValueError, "'Sleeve' is not attached to 'Tube'", self.api.detach, host, target)

    def test_another_kind_counts_at_once(self):
        host, target = solved(), sleeve()
        self.api.attach(host, [target])
        bent = shown_positions(target)
        host.arap.attachments[0].kind = "rigid"
        self.assertGreater(np.abs(shown_positions(target) - bent).max(), 0.05)
        self.assert_close(edge_lengths(target, shown_positions(target)), edge_lengths(target, rest_positions(target)))

    def test_again_its_present_place_counts(self):
        host, target = solved(), eye()
        self.api.attach(host, [target])
        before = shown_positions(target)
        target.location.z = 0.2
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(target), before)
        self.api.attach(host, [target])
        self.assertEqual(len(host.arap.attachments), 1)
        self.assertGreater(np.abs(shown_positions(target) - before).max(), 0.1)
        self.assert_close(shown_positions(target), self.carried(host, target), 1e-5)

    def test_who_cannot_go_along_is_told(self):
        host, target = posable(), sleeve()
        text = new_object("Label", bpy.data.curves.new("Label", "FONT"))
        hair = new_object("Hair", bpy.data.hair_curves.new("Hair"))
        hidden = sleeve(name="Elsewhere")
        self.scene.collection.objects.unlink(hidden)
        bpy.context.view_layer.update()
        other = mesh_object("Other")
        self.api.attach(other, [host])
        shared = new_object("Twin", target.data)
        moving = mesh_object("Moving")
        self.api.add_handle_for(host, moving)
        cases = (
            (host, "'Tube' cannot be attached to 'Tube': it is the mesh itself"),
            (
                text,
                "'Label' cannot be attached to 'Tube': convert it to a mesh first (Object > Convert)",
            ),
            (
                hair,
                (
                    "'Hair' cannot be attached to 'Tube': hair curves follow the surface that they grow on by "
                    "themselves (Deform Curves on Surface)"
                ),
            ),
            (
                host.arap.handles[0].target,
                "'Head' cannot be attached to 'Tube': it is neither a mesh nor a curve",
            ),
            (moving, "'Moving' cannot be attached to 'Tube': it is one of its handles"),
            (
                hidden,
                (
                    "'Elsewhere' cannot be attached to 'Tube': it is disabled in viewports or not in this view layer, "
                    "so its place is not known; enable it, or hide it with the eye"
                ),
            ),
            (other, "'Other' cannot be attached to 'Tube', which is attached to it: that would be a circle"),
            (
                shared,
                (
                    "The mesh of 'Twin' is shared with other objects, which would deform too: make it single-user "
                    "(Object > Relations > Make Single User > Object & Data)"
                ),
            ),
        )
        for obj, message in cases:
            self.assert_error(ValueError, message, self.api.attach, host, [eye(), obj])
            self.assertEqual(len(host.arap.attachments), 0, "all or none")
        bpy.data.objects.remove(shared)
        self.api.attach(other, [target])
        message = "'Sleeve' cannot be attached to 'Tube': it is attached to 'Other' already; detach it there first"
        self.assert_error(ValueError, message, self.api.attach, host, [target])
        message = "kind = 'soft', must be 'bend' or 'rigid', or '' for the one that fits"
        self.assert_error(ValueError, message, self.api.attach, host, [eye()], "soft")

    def test_what_goes_wrong_later_is_told_and_the_body_goes_on(self):
        host, target = posable(), sleeve()
        self.api.attach(host, [target])
        bpy.context.view_layer.objects.active = target
        bpy.ops.object.mode_set(mode="EDIT")
        self.assertEqual(self.problem(host), "'Sleeve' is in Edit Mode: it follows again in Object Mode")
        bend(host)
        self.api.solve(host)
        self.assertGreater(np.abs(shown_positions(host) - rest_positions(host)).max(), 0.5)
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.context.view_layer.update()
        self.assertEqual(self.problem(host), "")
        self.assert_follows(host, target)
        target.data.shape_keys.use_relative = False
        self.assertEqual(
            self.problem(host), "The shape keys of 'Sleeve' are absolute: turn on Relative in the shape keys panel"
        )
        target.data.shape_keys.use_relative = True
        target.show_only_shape_key = True
        self.assertEqual(
            self.problem(host), "'Sleeve' shows another shape key alone: turn off Shape Key Lock (the pin icon)"
        )
        target.show_only_shape_key = False
        target.shape_key_clear()
        self.api.solve(host)
        self.assertEqual(self.problem(host), "'Sleeve' has lost its shape keys: press Attach again")
        self.api.attach(host, [target])
        self.assert_follows(host, target)
        self.scene.collection.objects.unlink(target)
        self.assertEqual(self.problem(host), "'Sleeve' is in no scene: bring it back, or remove it from the list")
        bpy.data.objects.remove(target)
        self.assertEqual(self.problem(host), "The object is in no scene: bring it back, or remove it from the list")
        self.api.solve(host)
        module("attach.attachments").detach_at(host, 0)
        self.assertEqual(len(host.arap.attachments), 0)

    def test_a_fault_stops_nothing(self):
        host, target = solved(), sleeve()
        self.api.attach(host, [target])
        wrap = module("attach.wraps").get(host, host.arap.attachments[0])

        def fails(_positions):
            raise MemoryError

        wrap.carried = fails
        bend(host)
        self.api.solve(host)
        self.assertEqual(self.problem(host), "There is not enough memory")
        self.assertGreater(np.abs(shown_positions(host) - rest_positions(host)).max(), 0.5)
        del wrap.carried
        self.api.solve(host)
        self.assertEqual(self.problem(host), "")
        self.assert_follows(host, target)

    def test_a_linked_follower_is_told(self):
        (target,) = linked_back(sleeve(), "Sleeve")
        self.scene = bpy.context.scene
        self.scene.collection.objects.link(target)
        host = posable()
        bpy.context.view_layer.update()
        self.assert_error(
            ValueError,
            "'Sleeve' is linked from another file: make it local (Object > Relations > Make Local)",
            self.api.attach,
            host,
            [target],
        )

    def test_an_override_is_not_proposed(self):
        (target,) = linked_back(sleeve(), "Sleeve")
        override = target.override_create()
        bpy.context.scene.collection.objects.link(override)
        host = posable()
        self.assertEqual(module("attach.near").find_near(host, bpy.context.view_layer), [])
