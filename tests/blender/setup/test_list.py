# SPDX-License-Identifier: GPL-3.0-or-later
"""The one list of handles and pins, and the view; names of new entries."""

import numpy as np
from support import SceneTest, bpy, module
from tubes import BOTTOM, MIDDLE, RINGS, SEGMENTS, TOP, armature, mesh_object, posable, select_in_edit_mode


class ListTest(SceneTest):
    """The one list of handles and pins."""

    def setUp(self) -> None:
        super().setUp()
        self.obj = posable()
        self.api.add_handle(self.obj, MIDDLE, name="Waist")
        self.pin, self.first, self.second = (self.obj.arap.controls.find(name) for name in ("Feet", "Head", "Waist"))
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
        for index, target in ((self.first, self.head), (self.second, self.waist)):
            settings.active_control_index = index
            self.assertEqual((self.in_hand(), settings.active_control_index), ((target, [target]), index))
        settings.active_control_index = self.pin
        self.assertEqual((self.in_hand(), settings.active_control_index), ((self.obj, []), self.pin))
        self.assertEqual(self.obj.vertex_groups.active.name, "Feet")

    def test_what_is_selected_in_the_view_is_the_row(self):
        for target, index in ((self.waist, self.second), (self.head, self.first), (self.obj, self.first)):
            self.take(target)
            self.assertEqual(self.obj.arap.active_control_index, index)
            self.obj.arap.chosen_control_index = index

    def test_a_removed_entry_is_the_chosen_one_and_leaves_a_mesh_to_go_on_with(self):
        self.take(self.waist)
        self.obj.arap.chosen_control_index = self.first
        bpy.ops.arap.control_remove()
        self.assertEqual([control.name for control in self.obj.arap.controls], ["Feet", "Head"])
        self.assertEqual(bpy.context.object, self.obj)

    def test_of_two_with_one_name_the_chosen_one_is_removed(self):
        for _ in range(2):
            self.obj.arap.controls.add()["name"] = "Same"  # as a damaged file has it
        self.obj.arap.controls[-1].vertex_group = "Feet"
        self.obj.arap.chosen_control_index = len(self.obj.arap.controls) - 1
        bpy.ops.arap.control_remove()
        self.assertEqual([control.vertex_group for control in self.obj.arap.controls], ["Feet", "Head", "Waist", ""])

    def test_a_row_of_nothing_is_passed_over(self):
        self.obj.arap.active_control_index = 3
        self.assertIsNone(module("setup.chosen").chosen(self.obj))
        with self.assertRaisesRegex(RuntimeError, "Choose the pin, handle or bone to remove in the list"):
            bpy.ops.arap.control_remove()

    def test_in_pose_mode_a_click_selects_the_bone(self):
        rig = armature()
        for bone in ("Lower", "Upper"):
            self.api.add_handle_for(self.obj, rig, bone)
        self.take(rig)
        bpy.ops.object.mode_set(mode="POSE")
        for index, bone in ((4, "Upper"), (3, "Lower")):
            self.obj.arap.active_control_index = index
            self.assertEqual((self.obj.arap.active_control_index, rig.data.bones.active.name), (index, bone))
            self.assertEqual([item.name for item in bpy.context.selected_pose_bones], [bone])
        for index in (self.pin, self.first):  # the mode stays
            self.obj.arap.active_control_index = index
            self.assertEqual((self.obj.arap.active_control_index, bpy.context.object, rig.mode), (index, rig, "POSE"))
        rig.data.bones.active = rig.data.bones["Upper"]
        self.assertEqual(self.obj.arap.active_control_index, 4, "what is selected in the view")

    def test_of_two_handles_of_one_object_the_clicked_one_is_chosen(self):
        self.obj.arap.controls["Waist"].target = self.head
        for index in (self.second, self.first, self.second):
            self.obj.arap.active_control_index = index
            self.assertEqual((self.obj.arap.active_control_index, bpy.context.object), (index, self.head))

    def test_in_edit_mode_a_click_leaves_the_view_alone(self):
        bpy.ops.object.mode_set(mode="EDIT")
        self.obj.arap.active_control_index = self.second
        self.assertEqual((bpy.context.object, self.obj.arap.active_control_index), (self.obj, self.second))
        self.assertEqual(self.obj.mode, "EDIT")

    def test_names_are_unique_and_a_renamed_pin_renames_its_group(self):
        controls = self.obj.arap.controls
        controls["Feet"].name = "Head"
        self.assertEqual([control.name for control in controls], ["Head.001", "Head", "Waist"])
        self.assertEqual(controls["Head.001"].vertex_group, "Head.001")
        controls["Head.001"].name = ""
        self.assertEqual([control.name for control in controls], ["Pin", "Head", "Waist"])
        self.assertIn("Pin", self.obj.vertex_groups)


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
