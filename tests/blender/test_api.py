# SPDX-License-Identifier: GPL-3.0-or-later
"""The interface for scripts: the documented example runs as it stands, and everything promised is there."""

import re

import numpy as np
from looks import key_names, key_positions, rest_positions
from support import SceneTest, bpy
from tubes import mesh_object


def example(text: str) -> str:
    """The indented lines of a docstring."""
    return "\n".join(line[4:] for line in text.splitlines() if line.startswith("    "))


class ApiTest(SceneTest):
    def test_the_example_runs(self):
        obj = mesh_object("Creature")
        obj.modifiers.new("Dense", "SUBSURF").levels = 1
        with bpy.context.temp_override(object=obj, active_object=obj):
            bpy.ops.object.modifier_apply(modifier="Dense")
        self.assertGreater(len(obj.data.vertices), 503)
        lines = example(self.api.__doc__).splitlines()
        self.assertLessEqual(len(lines), 10)
        exec("\n".join(lines), {})
        self.assertEqual(key_names(obj), ["Basis", "ARAP", "Tail up"])
        moved = key_positions(obj, "Tail up") - rest_positions(obj)
        self.assert_close(moved[[501, 502, 503]], np.broadcast_to([0.0, 0.0, 0.5], (3, 3)), 1e-5)
        self.assert_close(moved[:40], np.zeros((40, 3)), 1e-6)

    def test_everything_public_is_documented_and_says_one_thing(self):
        for name in self.api.__all__:
            with self.subTest(name):
                item = getattr(self.api, name)
                self.assertTrue(item.__doc__)
                self.assertTrue(re.match(r"\S.*\S", item.__doc__.splitlines()[0]))

    def test_nothing_depends_on_selection_or_the_active_object(self):
        obj = mesh_object()
        other = mesh_object("Other")
        for item in (obj, other):
            item.select_set(False)
        bpy.context.view_layer.objects.active = other
        other.select_set(True)
        self.api.add_pin(obj, [0, 1, 2])
        handle = obj.arap.controls[self.api.add_handle(obj, [130])]
        handle.target.location.y += 0.2
        self.api.solve(obj)
        self.api.bake_animation(obj, 1, 2)
        self.assertIs(bpy.context.view_layer.objects.active, other)
        self.assertEqual(bpy.context.selected_objects, [other])
        self.assertIsNone(other.data.shape_keys)
