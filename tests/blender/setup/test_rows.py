# SPDX-License-Identifier: GPL-3.0-or-later
"""The one list of handles and pins, and the view; names of new entries."""

import numpy as np
from support import SceneTest, bpy, linked_back, module, opened_again
from tubes import BOTTOM, MIDDLE, RINGS, SEGMENTS, TOP, armature, mesh_object, posable, select_in_edit_mode


class RowsTest(SceneTest):
    """The one list of handles and pins."""

    def setUp(self) -> None:
        super().setUp()
        self.obj = posable()
        self.api.add_handle(self.obj, MIDDLE, name="Waist")
        self.head, self.waist = (handle.target for handle in self.obj.arap.handles)
        self.take(self.obj)

    def take(self, obj):
        for other in bpy.context.view_layer.objects:
            other.select_set(other == obj)
        bpy.context.view_layer.objects.active = obj

    def in_hand(self):
        return bpy.context.object, [obj for obj in bpy.context.view_layer.objects if obj.select_get()]

    def test_a_click_selects_in_the_view(self):
        settings = self.obj.arap
        self.assertEqual(len(settings.rows), 3)
        for row, target in ((0, self.head), (1, self.waist)):
            settings.shown_row = row
            self.assertEqual((self.in_hand(), settings.shown_row), ((target, [target]), row))
        settings.shown_row = 2
        self.assertEqual((self.in_hand(), settings.shown_row), ((self.obj, []), 2))
        self.assertEqual(self.obj.vertex_groups.active.name, "Feet")

    def test_what_is_selected_in_the_view_is_the_row(self):
        for target, row in ((self.waist, 1), (self.head, 0), (self.obj, 0)):
            self.take(target)
            self.assertEqual(self.obj.arap.shown_row, row)
            self.obj.arap.active_handle_index = row

    def test_a_removed_entry_is_the_chosen_one_and_leaves_a_mesh_to_go_on_with(self):
        self.take(self.waist)
        self.obj.arap.active_handle_index = 0
        bpy.ops.arap.handle_remove()
        self.assertEqual([handle.name for handle in self.obj.arap.handles], ["Head"])
        self.assertEqual((bpy.context.object, len(self.obj.arap.rows)), (self.obj, 2))

    def test_a_row_of_nothing_is_passed_over(self):
        rows = module("setup.rows")
        self.obj.arap.rows.add()
        self.assertIsNone(rows.entry_at(self.obj, 3))
        self.obj.arap.shown_row = 3

    def test_a_file_with_another_number_of_rows_is_put_right(self):
        self.obj.arap.rows.clear()
        self.assertEqual(len(opened_again().arap.rows), 3)

    def test_in_pose_mode_a_click_selects_the_bone(self):
        rig = armature()
        for bone in ("Lower", "Upper"):
            self.api.add_handle_for(self.obj, rig, bone)
        self.take(rig)
        bpy.ops.object.mode_set(mode="POSE")
        for row, bone in ((3, "Upper"), (2, "Lower")):
            self.obj.arap.shown_row = row
            self.assertEqual((self.obj.arap.shown_row, rig.data.bones.active.name), (row, bone))
            self.assertEqual([item.name for item in bpy.context.selected_pose_bones], [bone])
        for row in (4, 0):  # a pin, and a handle of another object: the mode stays
            self.obj.arap.shown_row = row
            self.assertEqual((self.obj.arap.shown_row, bpy.context.object, rig.mode), (row, rig, "POSE"))
        rig.data.bones.active = rig.data.bones["Upper"]
        self.assertEqual(self.obj.arap.shown_row, 3, "what is selected in the view")

    def test_of_two_handles_of_one_object_the_clicked_one_is_chosen(self):
        self.obj.arap.handles[1].target = self.head
        for row in (1, 0, 1):
            self.obj.arap.shown_row = row
            self.assertEqual((self.obj.arap.shown_row, bpy.context.object), (row, self.head))

    def test_rows_that_a_script_has_not_counted_are_counted_after_a_redraw(self):
        self.obj.arap.pins.add().name = "Feet"
        count = module("setup.rows").count_all
        module("setup.rows").count_soon(self.obj)
        self.assertTrue(bpy.app.timers.is_registered(count))
        bpy.app.timers.unregister(count)
        count()
        self.assertEqual(len(self.obj.arap.rows), 4)
        module("setup.rows").count_soon(self.obj)
        self.assertFalse(bpy.app.timers.is_registered(count))

    def test_an_override_without_rows_leaves_the_others_of_its_file_alone(self):
        """Blender lets nobody change the number of its rows."""
        self.obj.arap.rows.clear()
        tube, *heads = linked_back(self.obj, "Tube", "Head", "Waist")
        override = tube.override_create()
        for item in (override, *heads):
            bpy.context.scene.collection.objects.link(item)
        self.assertIsNotNone(override.override_library)
        local = posable("Zebra")
        local.arap.rows.clear()
        module("setup.rows").count_all()
        self.assertEqual((len(override.arap.rows), len(local.arap.rows)), (0, 2))

    def test_in_edit_mode_a_click_leaves_the_view_alone(self):
        bpy.ops.object.mode_set(mode="EDIT")
        self.obj.arap.shown_row = 1
        self.assertEqual((bpy.context.object, self.obj.arap.shown_row, self.obj.mode), (self.obj, 1, "EDIT"))


class NamesTest(SceneTest):
    """Of what is added without a name: by the artist's vertex group, else by side and place."""

    def add(self, obj, vertices, kind="handle"):
        select_in_edit_mode(obj, vertices)
        getattr(bpy.ops.arap, f"{kind}_add")()
        bpy.ops.arap.edit_mesh()
        return getattr(obj.arap, f"{kind}s")[-1]

    def test_by_side_and_place(self):
        obj = mesh_object()
        bpy.context.view_layer.objects.active = obj
        half = 8 * SEGMENTS
        for vertices, name in (
            (TOP, "Top"),
            (TOP, "Top.001"),
            ([half], "Middle.L"),
            ([half + SEGMENTS // 2], "Middle.R"),
            ([half + SEGMENTS // 4], "Back"),
            ([half + 3 * SEGMENTS // 4], "Front"),
            ([TOP[0]], "Top.L"),
        ):
            handle = self.add(obj, vertices)
            self.assertEqual((handle.name, handle.target.name.partition(".00")[0]), (name, name.partition(".00")[0]))
        self.assertEqual(self.add(obj, BOTTOM, "pin").name, "Bottom")

    def test_of_a_turned_object_as_it_is_seen(self):
        """Its parent stands it up, as of a file whose up is Y: along its own axes, the top would be the back."""
        obj, root = mesh_object(), bpy.data.objects.new("Root", None)
        obj.rotation_euler.z, root.rotation_euler.x = np.pi / 2, -np.pi / 2
        obj.parent = root
        bpy.context.scene.collection.objects.link(root)
        bpy.context.view_layer.objects.active = obj
        half = 8 * SEGMENTS
        for vertices, name in ((TOP, "Back"), ([half], "Bottom"), ([half + SEGMENTS // 4], "Middle.R")):
            self.assertEqual(self.add(obj, vertices).name, name)

    def test_by_the_group_of_the_artist(self):
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        obj.vertex_groups.new(name="Hand.L").add(range((RINGS - 2) * SEGMENTS, RINGS * SEGMENTS), 0.8, "REPLACE")
        obj.vertex_groups.new(name="Arm.L").add(range(RINGS * SEGMENTS), 0.2, "REPLACE")
        self.assertEqual(self.add(obj, TOP).name, "Hand.L")
        self.assertEqual(self.add(obj, MIDDLE).name, "Middle", "no group with little weight")

    def test_a_flat_mesh_has_places_too(self):
        name = module("setup.names").place_name
        self.assertEqual(name(np.array([[0.0, 0.0, 0.0]]), np.zeros(3), np.zeros(3)), "Middle")
