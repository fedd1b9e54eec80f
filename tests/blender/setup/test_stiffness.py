# SPDX-License-Identifier: GPL-3.0-or-later
"""Stiffness: what its entries do to the pose, and its operators."""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace

import numpy as np
from looks import key_positions, rest_positions
from support import SceneTest, bpy, module
from tubes import MIDDLE, SEGMENTS, posable, select_in_edit_mode, solved

BELLY = list(range(6 * SEGMENTS, 9 * SEGMENTS))
CHEST = list(range(10 * SEGMENTS, 13 * SEGMENTS))


def out_of_shape(obj, part) -> float:
    """How far the distances within some vertices are from those at rest, at most."""
    at_rest, now = (
        np.linalg.norm(p[:, None] - p[None], axis=2) for p in (rest_positions(obj)[part], key_positions(obj)[part])
    )
    return float(np.abs(now - at_rest).max())


def entries(obj) -> list[tuple[str, bool, float]]:
    return [(entry.name, entry.use_rigid, entry.factor) for entry in obj.arap.stiffness]


class StiffnessTest(SceneTest):
    def test_pieces_of_a_rigid_group_are_bodies_of_their_own(self):
        obj = solved()
        both = [*BELLY, *CHEST]
        entry = obj.arap.stiffness[self.api.add_rigid(obj, both, name="Armor")]
        self.api.solve(obj)
        for part in (BELLY, CHEST):
            self.assertLess(out_of_shape(obj, part), 1e-5)
        self.assertGreater(out_of_shape(obj, both), 0.05)
        entry.use_single_body = True
        self.api.solve(obj)
        self.assertLess(out_of_shape(obj, both), 1e-5)
        entry.is_enabled = False
        self.api.solve(obj)
        self.assertGreater(out_of_shape(obj, BELLY), 1e-2)

    def test_follow_and_painted_stiffness(self):
        obj = solved()
        obj.arap.use_follow = True
        bpy.context.view_layer.update()
        bent = out_of_shape(obj, BELLY)
        group = obj.vertex_groups.new(name="Belly")
        self.api.add_stiffness_group(obj, "Belly")
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
        group.add(BELLY, 1.0, "REPLACE")
        obj.data.update_tag()
        bpy.context.view_layer.update()
        self.assertLess(out_of_shape(obj, BELLY), 0.5 * bent)
        self.assertEqual((obj.arap.use_follow, obj.arap.follow_error), (True, ""))
        obj.arap.stiffness[0].use_rigid = True
        obj.update_tag()
        bpy.context.view_layer.update()
        self.assertLess(out_of_shape(obj, BELLY), 1e-5)

    def test_an_entry_without_a_group_is_refused_unless_disabled(self):
        obj = posable()
        obj.arap.stiffness[self.api.add_stiffness(obj, BELLY, name="Belly")].name = "Tail"
        message = (
            "Stiffness 'Tail' of 'Tube': there is no vertex group of that name; choose one or remove it from the list"
        )
        self.assert_error(ValueError, message, self.api.solve, obj)
        obj.arap.stiffness[0].is_enabled = False
        self.api.solve(obj)


class OperatorTest(SceneTest):
    def setUp(self):
        super().setUp()
        self.obj = posable()
        bpy.context.view_layer.objects.active = self.obj
        self.obj.select_set(True)

    def test_rigid_in_one_click(self):
        select_in_edit_mode(self.obj, [])
        with self.assertRaisesRegex(RuntimeError, "No vertices are selected: select the vertices to stiffen"):
            bpy.ops.arap.stiffness_add(use_rigid=True)
        select_in_edit_mode(self.obj, BELLY)
        self.assertEqual(bpy.ops.arap.stiffness_add(use_rigid=True), {"FINISHED"})
        self.assertEqual((self.obj.mode, entries(self.obj)), ("EDIT", [("Rigid", True, 100.0)]))
        bpy.ops.object.mode_set(mode="OBJECT")
        weights = module("scene.meshes").read_weights(self.obj, ["Rigid"])["Rigid"]
        self.assertEqual(np.flatnonzero(weights == 1.0).tolist(), BELLY)

    def test_what_is_made_in_edit_mode_is_one_step_of_undo(self):
        """Edit Mode's own steps have the mesh alone: the entry of the list would stay."""
        make_rigid = partial(bpy.ops.arap.stiffness_add, use_rigid=True)
        makers = (make_rigid, bpy.ops.arap.stiffness_add, bpy.ops.arap.pin_add, bpy.ops.arap.handle_add)
        select_in_edit_mode(self.obj, BELLY)
        bpy.ops.ed.undo_push(message="selected")
        for make in makers:
            self.assertEqual(make(), {"FINISHED"})
            self.assertEqual(self.obj.mode, "EDIT")
            self.assertEqual(self.counts(), (3, 3))
            bpy.ops.ed.undo()
            self.obj = bpy.data.objects["Tube"]
            self.assertEqual((self.counts(), self.obj.mode), ((2, 2), "EDIT"))
            self.assertEqual(module("scene.meshes").selected_vertices(self.obj).tolist(), BELLY)
        bpy.ops.object.mode_set(mode="OBJECT")

    def counts(self):
        """Entries of all lists and vertex groups, with objects."""
        settings = self.obj.arap
        n_entries = len(settings.pins) + len(settings.handles) + len(settings.stiffness)
        return n_entries, len(self.obj.vertex_groups)

    def test_the_dialog_has_the_active_group_unless_that_is_stiff_already(self):
        invoke = module("setup.list_operators").ARAP_OT_stiffness_add.invoke
        context = SimpleNamespace(
            object=self.obj,
            active_object=self.obj,
            view_layer=bpy.context.view_layer,
            window_manager=SimpleNamespace(invoke_props_dialog=lambda _: {"RUNNING_MODAL"}),
        )
        self.obj.vertex_groups.active_index = self.obj.vertex_groups.find("Head")
        for expected in ("Head", ""):
            dialog = SimpleNamespace(vertex_group="")
            self.assertEqual(invoke(dialog, context, None), {"RUNNING_MODAL"})
            self.assertEqual(dialog.vertex_group, expected)
            self.api.add_stiffness_group(self.obj, "Head")

    def test_add_takes_the_selection_a_group_or_a_new_one_to_paint(self):
        select_in_edit_mode(self.obj, MIDDLE)
        self.assertEqual(bpy.ops.arap.stiffness_add(name="Belly"), {"FINISHED"})
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assertEqual(bpy.ops.arap.stiffness_add(vertex_group="Head"), {"FINISHED"})
        bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
        self.assertEqual(bpy.ops.arap.stiffness_add(name="Painted"), {"FINISHED"})
        self.assertEqual([entry.name for entry in self.obj.arap.stiffness], ["Belly", "Head", "Painted"])
        self.assertEqual(self.obj.vertex_groups.active.name, "Painted")
        for _ in range(3):
            self.assertEqual(bpy.ops.arap.stiffness_remove(), {"FINISHED"})
        self.assertEqual(sorted(group.name for group in self.obj.vertex_groups), ["Feet", "Head"])
        self.assertFalse(bpy.ops.arap.stiffness_remove.poll())

    def test_what_refuses_the_mesh_leaves_no_group(self):
        """Sculpt Mode, and a mesh without faces: the button is there, and says what to do."""
        bpy.ops.object.mode_set(mode="SCULPT")
        with self.assertRaisesRegex(RuntimeError, "'Tube' is in Sculpt Mode: go back to Object Mode first"):
            bpy.ops.arap.stiffness_add()
        self.assertEqual(self.obj.vertex_groups.keys(), ["Feet", "Head"])
        bpy.ops.object.mode_set(mode="OBJECT")
        self.obj.data.clear_geometry()  # of its groups, too
        with self.assertRaisesRegex(RuntimeError, "'Tube' has no faces: there is nothing to deform"):
            bpy.ops.arap.stiffness_add()
        self.assertEqual(self.obj.vertex_groups.keys(), [])
