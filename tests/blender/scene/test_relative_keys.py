# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys that are relative to a key that the add-on writes."""

import numpy as np
from looks import key_positions
from support import SceneTest, bpy, module
from tubes import animated, mesh_object, own_key


class RelativeKeyTest(SceneTest):
    """Keys of the artist's own that are relative to one that the add-on writes keep what they add to it."""

    def fix_of(self, obj, name, shift=0.25):
        """A key relative to another one, and one relative to that."""
        base = obj.data.shape_keys.key_blocks[name]
        fix = own_key(obj, f"Fix of {name}", shift, value=1.0)
        fix.data.foreach_set("co", (key_positions(obj, name) + np.array([shift, 0.0, 0.0])).ravel())
        fix.relative_key = base
        more = own_key(obj, f"More of {name}", value=0.0)
        more.data.foreach_set("co", (key_positions(obj, fix.name) + np.array([0.0, shift, 0.0])).ravel())
        more.relative_key = fix
        obj.data.update_tag()
        return fix, more

    def assert_adds(self, obj, key, *shift):
        offset = key_positions(obj, key.name) - key_positions(obj, key.relative_key.name)
        self.assert_close(offset, np.broadcast_to(shift, offset.shape), 1e-5)

    def test_to_the_pose(self):
        obj = animated()
        self.scene.frame_set(11)
        self.api.solve(obj)
        fix, more = self.fix_of(obj, "ARAP")
        for act in (
            lambda: (self.scene.frame_set(17), self.api.solve(obj)),
            lambda: self.api.reset_pose(obj),
            lambda: (self.scene.frame_set(11), self.api.solve(obj)),
            lambda: self.api.apply_pose_as_rest(obj),
        ):
            act()
            self.assertEqual((fix.relative_key.name, more.relative_key.name), ("ARAP", fix.name))
            self.assert_adds(obj, fix, 0.25, 0.0, 0.0)
            self.assert_adds(obj, more, 0.0, 0.25, 0.0)

    def test_to_a_baked_key(self):
        obj = animated()
        names = self.api.bake_animation(obj, 1, 21, 10)
        fixes = [self.fix_of(obj, name) for name in names]
        self.api.bake_animation(obj, 11, 41, 10)  # its first key has another name, its last is another pose
        for (fix, more), base in zip(fixes, ("Basis", "ARAP_0011", "ARAP_0021"), strict=True):
            self.assertEqual((fix.relative_key.name, more.relative_key.name), (base, fix.name))
            self.assert_adds(obj, fix, 0.25, 0.0, 0.0)
            self.assert_adds(obj, more, 0.0, 0.25, 0.0)
        module("scene.baked").edit_again(obj, is_removing=True)
        for fix, _ in fixes:
            self.assertEqual(fix.relative_key.name, "Basis")
            self.assert_adds(obj, fix, 0.25, 0.0, 0.0)

    def test_to_a_stored_pose_and_a_twin(self):
        obj, shirt = animated(), mesh_object("Shirt")
        self.api.attach(obj, [shirt])
        self.scene.frame_set(11)
        self.api.store_pose(obj, "Far")
        self.api.solve(obj)
        self.api.poses_to_keys(obj)
        made = [(o, *self.fix_of(o, name)) for o in (obj, shirt) for name in ("ARAP", "Far")]
        self.scene.frame_set(17)
        obj.arap.handles[0].target.location.x += 0.5
        bpy.context.view_layer.update()
        self.api.store_pose(obj, "Far")
        self.api.solve(obj)
        self.api.poses_to_keys(obj)
        for o, fix, more in made:
            self.assertNotEqual(fix.relative_key.name, "Basis")
            self.assert_adds(o, fix, 0.25, 0.0, 0.0)
            self.assert_adds(o, more, 0.0, 0.25, 0.0)
