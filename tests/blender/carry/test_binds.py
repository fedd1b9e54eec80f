# SPDX-License-Identifier: GPL-3.0-or-later
"""Carry Along: how followers are prepared."""

from clothes import CarryTest, eye, sleeve
from looks import rest_positions
from support import module, uid
from tubes import bend, posable, solved


class BindTest(CarryTest):
    def test_what_ends_a_bind_in_the_background_switches_the_follower_off(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        wraps, follower = module("carry.wraps"), body.arap.followers[0]
        wraps.forget(uid("Sleeve"))
        wraps.begin(body, follower)
        binding = wraps._binding[uid("Sleeve")]
        if wraps.is_binding(uid("Sleeve")):  # it may have ended
            self.assertTrue(binding.wait().text.startswith("Preparing Sleeve, "))
        text = "Preparing 'Sleeve' cancelled: it does not go along until it is ticked in the list"
        self.assertEqual(binding.give_up(), text)
        self.assertEqual((follower.is_enabled, wraps.is_any_binding()), (False, False))
        self.assert_at_rest(target)
        follower.is_enabled = True
        self.assert_goes_along(body, target)

    def test_who_needs_a_bind_that_is_under_way_waits_for_it(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        wraps, follower = module("carry.wraps"), body.arap.followers[0]
        for is_edited in (False, True):
            wraps.forget(uid("Sleeve"))
            wraps.begin(body, follower)
            begun = wraps._binding[uid("Sleeve")].work
            if is_edited:
                module("scene.versions").write_key(target.data.shape_keys.reference_key, rest_positions(target) * 1.1)
                wraps.suspect(uid("Sleeve"))
            self.assertIs(wraps.bound(body, follower) is begun.result(), not is_edited)
            self.assertFalse(wraps.is_any_binding())

    def test_followers_share_what_is_prepared_of_the_body_and_let_it_go(self):
        body, targets = posable(), [sleeve(), eye(), sleeve(name="Cuff")]
        self.api.carry_along(body, targets)
        bend(body)
        self.api.solve(body)
        wraps = module("carry.wraps")
        self.assertEqual(len({id(wraps._bound[target.session_uid]._surface) for target in targets}), 1)
        self.assertIsNone(wraps._prepared._kept)
