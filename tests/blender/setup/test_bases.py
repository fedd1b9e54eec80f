# SPDX-License-Identifier: GPL-3.0-or-later
"""The base of a pin or handle: an attribute of the mesh, which Blender keeps."""

import bmesh
import numpy as np
from looks import key_positions, rest_positions
from support import SceneTest, bpy, opened_again
from tubes import BOTTOM, MIDDLE, SEGMENTS, TOP, copied, empty_at, solved

STAYS = 1e-4
RING = [v - 2 * SEGMENTS for v in MIDDLE]


def attributes(obj):
    return sorted(a.name for a in obj.data.attributes if a.name.startswith(".arap"))


def pinned():
    """A bent tube whose middle was pinned as it was bent."""
    obj = solved()
    return obj, key_positions(obj)


class BaseTest(SceneTest):
    def test_a_mesh_at_rest_has_none(self):
        obj = solved()
        self.api.reset_handles(obj)
        self.api.solve(obj)
        self.api.add_pin(obj, MIDDLE)
        self.assertEqual((attributes(obj), obj.arap.pins[-1].base_id), ([], 0))

    def test_entries_share_a_layer_unless_they_have_vertices_in_common(self):
        obj, posed = pinned()
        self.api.add_pin(obj, MIDDLE, name="One")
        self.api.add_pin(obj, RING, name="Two")
        self.assertEqual(attributes(obj), [".arap_base", ".arap_base_of"])
        self.api.add_pin(obj, [*MIDDLE, *RING], name="Both")
        self.assertEqual(len(attributes(obj)), 4)
        for name, vertices in (("One", MIDDLE), ("Two", RING), ("Both", sorted([*MIDDLE, *RING]))):
            base = obj.arap.pins[name].base
            self.assertEqual(base[0].tolist(), sorted(vertices))
            self.assert_close(rest_positions(obj)[base[0]] + base[1], posed[base[0]], 1e-5)
        self.api.remove_pin(obj, obj.arap.pins.find("One"))
        self.api.add_pin(obj, MIDDLE, name="Again")
        self.assertEqual(len(attributes(obj)), 4, "what a removed one held is free")

    def test_a_vertex_that_is_deleted_elsewhere_moves_nothing(self):
        obj, posed = pinned()
        self.api.add_pin(obj, MIDDLE, name="Waist")
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.mode_set(mode="EDIT")
        edited = bmesh.from_edit_mesh(obj.data)
        edited.verts.ensure_lookup_table()
        gone = 3 * SEGMENTS  # between feet and waist: the waist has other numbers now
        bmesh.ops.delete(edited, geom=[edited.verts[gone]], context="VERTS")
        bmesh.update_edit_mesh(obj.data)
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assertEqual(obj.arap.pins["Waist"].base[0].tolist(), [v - 1 for v in MIDDLE])
        self.api.solve(obj)
        now = np.insert(key_positions(obj), gone, posed[gone], axis=0)
        self.assert_close(now[MIDDLE], posed[MIDDLE], STAYS)

    def test_a_file_and_a_copy_have_it(self):
        obj, posed = pinned()
        self.api.add_pin(obj, MIDDLE, name="Waist")
        obj.arap.handles[0].is_enabled = False
        for again in (lambda: copied(obj), opened_again):
            each = again()
            self.api.solve(each)
            self.assert_close(key_positions(each)[MIDDLE], posed[MIDDLE], STAYS)

    def test_it_is_set_and_read_in_edit_mode(self):
        obj, posed = pinned()
        handle = self.api.add_handle(obj, MIDDLE, name="Waist")
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.mode_set(mode="EDIT")
        handle.target = empty_at((1.0, 2.0, 3.0), "Other")  # the ring was bent, so no motion from rest shows it
        vertices, offsets = handle.base
        self.assertEqual(vertices.tolist(), MIDDLE)
        self.assertGreater(np.abs(offsets).max(), 1e-3)
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assert_close(handle.base[1], offsets, 0.0)
        self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, STAYS)

    def test_what_holds_nothing_any_more_is_at_rest(self):
        obj, _ = pinned()
        self.api.add_pin(obj, MIDDLE, name="Waist")
        self.api.reset_handles(obj)
        self.assertEqual([pin.base_id for pin in obj.arap.pins], [0, 0])
        bpy.context.view_layer.update()
        self.api.solve(obj)
        self.assert_close(
            key_positions(obj)[[*BOTTOM, *MIDDLE, *TOP]], rest_positions(obj)[[*BOTTOM, *MIDDLE, *TOP]], STAYS
        )
