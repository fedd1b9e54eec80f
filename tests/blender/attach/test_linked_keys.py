# SPDX-License-Identifier: GPL-3.0-or-later
"""Attach: the keys of an attached object, the artist's own and those that stand for the host's."""

import numpy as np
from clothes import AttachTest, eye, sleeve
from looks import key_names, key_positions, rest_positions, shown_positions
from support import bpy
from tubes import bend, own_key, solved


class TwinsTest(AttachTest):
    def test_keys_of_its_own_stay(self):
        host, target = solved(), sleeve()
        own_key(target, "ARAP", 0.5, value=1.0)
        self.api.attach(host, [target])
        self.assertEqual(key_names(target), ["Basis", "ARAP", "ARAP.001"])
        target.data.shape_keys.key_blocks["ARAP.001"].name = "Renamed"
        bend(host)
        self.api.solve(host)
        self.assertEqual(key_names(target), ["Basis", "ARAP", "Renamed"])
        self.assert_close(key_positions(target), rest_positions(target) + np.array([0.5, 0.0, 0.0]))
        self.api.detach(host, target)
        self.assertEqual(key_names(target), ["Basis", "ARAP"])

    def test_a_twin_that_became_the_reference_key_is_not_written(self):
        """The artist has removed Basis. What was shown is the rest shape now."""
        host, target = solved(), sleeve()
        self.api.attach(host, [target])
        target.shape_key_remove(target.data.shape_keys.reference_key)
        rest = rest_positions(target)
        self.api.solve(host)
        self.assert_close(rest_positions(target), rest, 0.0)
        self.assertEqual(key_names(target), ["ARAP", "ARAP.001"])
        self.assert_follows(host, target)

    def test_a_key_that_the_artist_removes_takes_its_twin_along(self):
        host, target = solved(), sleeve()
        self.api.attach(host, [target])
        host.shape_key_remove(host.data.shape_keys.key_blocks["ARAP"])
        bpy.context.view_layer.update()
        self.assertEqual(key_names(target), ["Basis"])
        self.api.solve(host)
        host.shape_key_clear()
        bpy.context.view_layer.update()
        self.assertEqual(key_names(target), ["Basis"])

    def test_a_key_that_the_artist_renames_keeps_its_twin(self):
        """As of any key that the artist has made his own, the add-on writes neither any more."""
        host, target, buckle = solved(), sleeve(), eye()
        self.api.attach(host, [target])
        self.api.attach(target, [buckle])
        self.api.bake_pose(host, "Wave")
        keys, shown = host.data.shape_keys.key_blocks, shown_positions(target)
        keys["ARAP"].name = "Kept"
        keys["Wave"].name = "Hello"
        bpy.context.view_layer.update()
        for obj in (target, buckle):
            self.assertEqual(key_names(obj), ["Basis", "Kept", "Hello"])
        self.assert_close(shown_positions(target), shown, 1e-6)
        keys["Kept"].value, keys["Hello"].value = 0.0, 1.0
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(target), shown, 1e-6)
        self.api.solve(host)
        for obj in (target, buckle):
            self.assertEqual(key_names(obj), ["Basis", "Kept", "Hello", "ARAP"])
        self.api.detach(host, target)
        self.assertEqual(key_names(target), ["Basis", "Kept", "Hello"])
