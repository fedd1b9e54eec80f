# SPDX-License-Identifier: GPL-3.0-or-later
"""The base of a pin or handle: an attribute of the mesh, which Blender keeps."""

from unittest import mock

import bmesh
import numpy as np
from looks import group_of, key_positions, rest_positions
from support import SceneTest, bpy, module, opened_again
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
            base = obj.arap.controls[name].base
            self.assertEqual(base[0].tolist(), sorted(vertices))
            self.assert_close(rest_positions(obj)[base[0]] + base[1], posed[base[0]], 1e-5)
        self.api.remove_control(obj, "One")
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
        self.assertEqual(obj.arap.controls["Waist"].base[0].tolist(), [v - 1 for v in MIDDLE])
        self.api.solve(obj)
        now = np.insert(key_positions(obj), gone, posed[gone], axis=0)
        self.assert_close(now[MIDDLE], posed[MIDDLE], STAYS)

    def test_new_vertices_between_held_ones_are_held_as_they_are(self):
        """Blender makes whole numbers of new vertices in single precision."""
        obj, _ = pinned()
        held = [*RING, *range(RING[-1] + 1, MIDDLE[0]), *MIDDLE]
        self.api.add_pin(obj, held, name="Waist")
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="DESELECT")
        bpy.ops.mesh.select_mode(type="VERT")
        bpy.ops.object.mode_set(mode="OBJECT")
        for vertex in held:
            obj.data.vertices[vertex].select = True
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.subdivide()
        bpy.ops.object.mode_set(mode="OBJECT")
        weights = group_of(obj, "Waist")
        whole = [v for v, weight in weights.items() if weight == 1.0]
        self.assertGreater(len(whole), 1.5 * len(held))
        self.assertEqual(obj.arap.controls["Waist"].base[0].tolist(), whole)

    def test_a_twin_with_the_same_mesh_takes_nothing_away(self):
        obj, posed = pinned()
        pin = obj.arap.controls[self.api.add_pin(obj, MIDDLE, name="Waist")]
        twin = obj.copy()
        self.scene.collection.objects.link(twin)
        bpy.context.view_layer.update()
        self.api.reset_handles(twin)
        self.assertEqual((twin.arap.controls["Waist"].base_id, pin.base[0].tolist()), (0, MIDDLE))
        bpy.data.objects.remove(twin)
        self.api.solve(obj)
        self.assert_close(key_positions(obj)[MIDDLE], posed[MIDDLE], STAYS)

    def test_no_two_have_the_same_number(self):
        obj, _ = pinned()
        numbers = mock.patch.object(module("props.base_shape").secrets, "randbelow", side_effect=[4, 4, 4, 8])
        with numbers:
            for vertices in (MIDDLE, RING):
                self.api.add_pin(obj, vertices)
        self.assertEqual([pin.base_id for pin in obj.arap.pins[1:]], [5, 9])

    def test_what_is_restored_after_more_was_added_has_no_more(self):
        obj, _ = pinned()
        preserve_shape = module("scene.preserve_shape")
        self.api.add_pin(obj, MIDDLE, name="Waist")
        former = preserve_shape.capture_bases(obj)
        self.api.add_pin(obj, [*MIDDLE, *RING], name="Both")
        number = obj.arap.controls["Both"].base_id
        self.assertEqual([pin.name for pin in preserve_shape.restore_bases(obj, former)], ["Both"])
        self.assertEqual(obj.arap.controls["Waist"].base[0].tolist(), MIDDLE)
        owners = [
            np.array([v.value for v in obj.data.attributes[name].data]) for name in attributes(obj) if "_of" in name
        ]
        self.assertFalse(any((numbers == number).any() for numbers in owners))

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
        handle = obj.arap.controls[self.api.add_handle(obj, MIDDLE, name="Waist")]
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

    def test_edit_mode_gives_back_what_it_takes_and_touches_nothing_else(self):
        for name, kind, domain in ((".arap_base_of", "FLOAT", "POINT"), (".arap_base", "INT", "FACE"), ("", "", "")):
            with self.subTest(name, kind=kind):
                self.setUp()
                obj, _ = pinned()
                if name:
                    obj.data.attributes.new(name, kind, domain)
                other = self.api.add_pin(obj, [*RING, MIDDLE[0]], name="Ring")
                handle = obj.arap.controls[self.api.add_handle(obj, MIDDLE, name="Waist")]
                held = [array.tolist() for array in obj.arap.controls[other].base]
                n_attributes = len(attributes(obj))
                bpy.context.view_layer.objects.active = obj
                bpy.ops.object.mode_set(mode="EDIT")
                for i in range(4):
                    handle.target = empty_at((1.0, 2.0, 3.0 + i), f"Other {i}")
                    self.assertEqual(handle.base[0].tolist(), MIDDLE)
                bpy.ops.object.mode_set(mode="OBJECT")
                self.assertEqual([array.tolist() for array in obj.arap.controls[other].base], held)
                self.assertLessEqual(len(attributes(obj)), n_attributes + 2)
                if name:
                    attribute = obj.data.attributes[name]
                    self.assertEqual((attribute.data_type, attribute.domain), (kind, domain))

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
