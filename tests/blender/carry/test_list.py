# SPDX-License-Identifier: GPL-3.0-or-later
"""Carry Along: who may follow whom, and what is told if one cannot."""

import numpy as np
from clothes import CarryTest, eye, new_object, sleeve
from looks import edge_lengths, key_names, rest_positions, shown_positions
from support import bpy, linked_back, module
from tubes import bend, mesh_object, posable, solved


class ListTest(CarryTest):
    def test_remove_and_the_tick_take_back_what_was_made(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        body.arap.followers[0].is_enabled = False
        self.assertEqual(key_names(target), ["Basis"])
        self.assert_at_rest(target)
        body.arap.followers[0].is_enabled = True
        self.assert_goes_along(body, target)
        self.api.stop_carrying(body, target)
        self.assertEqual((key_names(target), len(body.arap.followers)), ([], 0))
        self.assert_error(ValueError, "'Sleeve' does not go along with 'Tube'", self.api.stop_carrying, body, target)

    def test_another_kind_counts_at_once(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        bent = shown_positions(target)
        body.arap.followers[0].kind = "rigid"
        self.assertGreater(np.abs(shown_positions(target) - bent).max(), 0.05)
        self.assert_close(edge_lengths(target, shown_positions(target)), edge_lengths(target, rest_positions(target)))

    def test_again_its_present_place_counts(self):
        body, target = solved(), eye()
        self.api.carry_along(body, [target])
        before = shown_positions(target)
        target.location.z = 0.2
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(target), before)
        self.api.carry_along(body, [target])
        self.assertEqual(len(body.arap.followers), 1)
        self.assertGreater(np.abs(shown_positions(target) - before).max(), 0.1)
        self.assert_close(shown_positions(target), self.carried(body, target), 1e-5)

    def test_who_cannot_go_along_is_told(self):
        body, target = posable(), sleeve()
        text = new_object("Label", bpy.data.curves.new("Label", "FONT"))
        hair = new_object("Hair", bpy.data.hair_curves.new("Hair"))
        hidden = sleeve(name="Elsewhere")
        self.scene.collection.objects.unlink(hidden)
        bpy.context.view_layer.update()
        other = mesh_object("Other")
        self.api.carry_along(other, [body])
        shared = new_object("Twin", target.data)
        moving = mesh_object("Moving")
        self.api.add_handle_for(body, moving)
        cases = (
            (body, "'Tube' cannot go along with 'Tube': it is the mesh itself"),
            (
                text,
                "'Label' cannot go along with 'Tube': convert it to a mesh first (Object > Convert)",
            ),
            (
                hair,
                (
                    "'Hair' cannot go along with 'Tube': hair curves follow the surface that they grow on by "
                    "themselves (Deform Curves on Surface)"
                ),
            ),
            (
                body.arap.handles[0].target,
                "'Head' cannot go along with 'Tube': it is neither a mesh nor a curve",
            ),
            (moving, "'Moving' cannot go along with 'Tube': it is one of its handles"),
            (
                hidden,
                (
                    "'Elsewhere' cannot go along with 'Tube': it is disabled in viewports or not in this view layer, "
                    "so its place is not known; enable it, or hide it with the eye"
                ),
            ),
            (other, "'Other' cannot go along with 'Tube', which goes along with it: that would be a circle"),
            (
                shared,
                (
                    "The mesh of 'Twin' is shared with other objects, which would deform too: make it single-user "
                    "(Object > Relations > Make Single User > Object & Data)"
                ),
            ),
        )
        for obj, message in cases:
            self.assert_error(ValueError, message, self.api.carry_along, body, [eye(), obj])
            self.assertEqual(len(body.arap.followers), 0, "all or none")
        bpy.data.objects.remove(shared)
        self.api.carry_along(other, [target])
        message = (
            "'Sleeve' cannot go along with 'Tube': it goes along with 'Other' already; remove it from the list there "
            "first"
        )
        self.assert_error(ValueError, message, self.api.carry_along, body, [target])
        message = "kind = 'soft', must be 'bend' or 'rigid', or '' for the one that fits"
        self.assert_error(ValueError, message, self.api.carry_along, body, [eye()], "soft")

    def test_what_goes_wrong_later_is_told_and_the_body_goes_on(self):
        body, target = posable(), sleeve()
        self.api.carry_along(body, [target])
        bpy.context.view_layer.objects.active = target
        bpy.ops.object.mode_set(mode="EDIT")
        self.assertEqual(self.problem(body), "'Sleeve' is in Edit Mode: it goes along again in Object Mode")
        bend(body)
        self.api.solve(body)
        self.assertGreater(np.abs(shown_positions(body) - rest_positions(body)).max(), 0.5)
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.context.view_layer.update()
        self.assertEqual(self.problem(body), "")
        self.assert_goes_along(body, target)
        target.data.shape_keys.use_relative = False
        self.assertEqual(
            self.problem(body), "The shape keys of 'Sleeve' are absolute: turn on Relative in the shape keys panel"
        )
        target.data.shape_keys.use_relative = True
        target.show_only_shape_key = True
        self.assertEqual(
            self.problem(body), "'Sleeve' shows another shape key alone: turn off Shape Key Lock (the pin icon)"
        )
        target.show_only_shape_key = False
        target.shape_key_clear()
        self.api.solve(body)
        self.assertEqual(self.problem(body), "'Sleeve' has lost its shape keys: press Carry Along again")
        self.api.carry_along(body, [target])
        self.assert_goes_along(body, target)
        self.scene.collection.objects.unlink(target)
        self.assertEqual(self.problem(body), "'Sleeve' is in no scene: bring it back, or remove it from the list")
        bpy.data.objects.remove(target)
        self.assertEqual(self.problem(body), "The object is in no scene: bring it back, or remove it from the list")
        self.api.solve(body)
        module("carry.lists").remove_at(body, 0)
        self.assertEqual(len(body.arap.followers), 0)

    def test_a_fault_stops_nothing(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        wrap = module("carry.wraps").get(body, body.arap.followers[0])

        def fails(_positions):
            raise MemoryError

        wrap.carried = fails
        bend(body)
        self.api.solve(body)
        self.assertEqual(self.problem(body), "There is not enough memory")
        self.assertGreater(np.abs(shown_positions(body) - rest_positions(body)).max(), 0.5)
        del wrap.carried
        self.api.solve(body)
        self.assertEqual(self.problem(body), "")
        self.assert_goes_along(body, target)

    def test_a_linked_follower_is_told(self):
        (target,) = linked_back(sleeve(), "Sleeve")
        self.scene = bpy.context.scene
        self.scene.collection.objects.link(target)
        body = posable()
        bpy.context.view_layer.update()
        self.assert_error(
            ValueError,
            "'Sleeve' is linked from another file: make it local (Object > Relations > Make Local)",
            self.api.carry_along,
            body,
            [target],
        )

    def test_an_override_is_not_proposed(self):
        (target,) = linked_back(sleeve(), "Sleeve")
        override = target.override_create()
        bpy.context.scene.collection.objects.link(override)
        body = posable()
        self.assertEqual(module("carry.near").find_near(body, bpy.context.view_layer), [])
