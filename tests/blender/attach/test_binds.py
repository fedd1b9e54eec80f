# SPDX-License-Identifier: GPL-3.0-or-later
"""Attach: how objects are bound."""

from clothes import AttachTest, eye, sleeve
from looks import rest_positions
from support import module, uid
from tubes import bend, posable, solved


class BindTest(AttachTest):
    def test_what_ends_a_bind_in_the_background_switches_the_attachment_off(self):
        host, target = solved(), sleeve()
        self.api.attach(host, [target])
        wraps, attachment = module("attach.wraps"), host.arap.attachments[0]
        state = module("attach.states").of(uid("Sleeve"))
        wraps.unbind(uid("Sleeve"))
        wraps.begin(host, attachment)
        binding = state.binding
        if wraps.is_binding(uid("Sleeve")):  # it may have ended
            self.assertTrue(binding.wait().text.startswith("Preparing Sleeve, "))
        text = "Preparing 'Sleeve' cancelled: it does not follow until it is ticked in the list"
        self.assertEqual(binding.cancel(), text)
        self.assertEqual((attachment.is_enabled, state.binding), (False, None))
        self.assert_at_rest(target)
        attachment.is_enabled = True
        self.assert_follows(host, target)

    def test_who_needs_a_bind_that_is_under_way_waits_for_it(self):
        host, target = solved(), sleeve()
        self.api.attach(host, [target])
        wraps, attachment = module("attach.wraps"), host.arap.attachments[0]
        state = module("attach.states").of(uid("Sleeve"))
        for is_edited in (False, True):
            wraps.unbind(uid("Sleeve"))
            wraps.begin(host, attachment)
            begun = state.binding.work
            if is_edited:
                module("scene.versions").write_key(target.data.shape_keys.reference_key, rest_positions(target) * 1.1)
                state.must_check = True
            self.assertIs(wraps.bound(host, attachment) is begun.result(), not is_edited)
            self.assertIsNone(state.binding)

    def test_binds_share_what_is_prepared_of_the_host_and_let_it_go(self):
        host, targets = posable(), [sleeve(), eye(), sleeve(name="Cuff")]
        self.api.attach(host, targets)
        bend(host)
        self.api.solve(host)
        states = [module("attach.states").of(target.session_uid) for target in targets]
        self.assertEqual(len({id(state.wrap._surface) for state in states}), 1)
        self.assertIsNone(module("attach.wraps")._prepared._kept)
