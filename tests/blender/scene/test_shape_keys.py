# SPDX-License-Identifier: GPL-3.0-or-later
"""The key that takes the pose: what is made, what is left alone, what is refused."""

import numpy as np
from looks import key_positions, rest_positions, shown_positions
from support import SceneTest, bpy, linked_back, module
from tubes import TOP, bend, mesh_object, move, own_key, posable, solved


class ShapeKeyTest(SceneTest):
    def test_solve_makes_basis_and_key_and_shows_the_pose(self):
        obj = posable()
        rest = rest_positions(obj)
        bend(obj)
        self.api.solve(obj)
        keys = obj.data.shape_keys
        self.assertEqual([key.name for key in keys.key_blocks], ["Basis", "ARAP"])
        self.assertEqual(keys.key_blocks["ARAP"].value, 1.0)
        self.assertEqual(keys.key_blocks["ARAP"].relative_key, keys.reference_key)
        self.assert_close(key_positions(obj, "Basis"), rest, 1e-7)
        self.assert_close(shown_positions(obj), key_positions(obj), 1e-6)
        self.assertGreater(np.abs(shown_positions(obj) - rest).max(), 1.0)

    def test_a_slider_that_was_moved_is_set_again(self):
        obj = posable()
        self.api.solve(obj)
        key = obj.data.shape_keys.key_blocks["ARAP"]
        key.value, key.slider_max = 0.2, 0.5
        self.api.solve(obj)
        self.assertEqual(key.value, 1.0)

    def test_other_keys_stay_and_add_on_top(self):
        obj = mesh_object()
        smile = own_key(obj, "Smile")
        self.api.add_pin(obj, range(8))
        handle = obj.arap.controls[self.api.add_handle(obj, TOP)]
        bpy.context.view_layer.update()
        before = key_positions(obj, "Smile")
        move(handle.target, (0.0, 0.5, 0.0))
        self.api.solve(obj)
        self.assert_close(key_positions(obj, "Smile"), before, 0.0)
        self.assertEqual(smile.value, 1.0)
        self.assert_close(shown_positions(obj), key_positions(obj) + np.array([0.25, 0.0, 0.0]), 1e-5)

    def test_subdivision_and_armature_after_the_key_deform_the_posed_mesh(self):
        obj = solved()
        posed = key_positions(obj)
        rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
        self.scene.collection.objects.link(rig)
        bpy.context.view_layer.objects.active = rig
        bpy.ops.object.mode_set(mode="EDIT")
        bone = rig.data.edit_bones.new("Bone")
        bone.tail = (0.0, 0.0, 1.0)
        bpy.ops.object.mode_set(mode="OBJECT")
        obj.vertex_groups.new(name="Bone").add(range(len(posed)), 1.0, "REPLACE")
        obj.modifiers.new("Rig", "ARMATURE").object = rig
        rig.pose.bones["Bone"].location = (0.0, 2.0, 0.0)
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(obj) - posed, np.broadcast_to([0.0, 0.0, 2.0], posed.shape), 1e-4)
        obj.modifiers.new("Smooth", "SUBSURF")
        self.assertGreater(len(shown_positions(obj)), 3 * len(posed))
        self.api.solve(obj)  # the pose is that of the mesh below: nothing that comes after it counts
        self.assert_close(key_positions(obj), posed, 1e-4)

    def test_what_would_hide_the_pose_is_refused(self):
        obj = posable()
        self.api.solve(obj)
        keys = obj.data.shape_keys
        key = keys.key_blocks["ARAP"]
        other = obj.shape_key_add(name="Other")
        obj.vertex_groups.new(name="Half")

        def check(message, function=self.api.solve):
            before = key_positions(obj)
            self.assert_error(ValueError, message, function, obj)
            self.assert_close(key_positions(obj), before, 0.0)

        bend(obj)
        key.mute = True
        muted = (
            "Shape key 'ARAP' of 'Tube' is muted, so the pose would not show: "
            "press Edit Again after a bake, else unmute it"
        )
        check(muted)
        check(muted, module("engine.update").update_pose)
        key.mute = False

        obj.show_only_shape_key = True
        obj.active_shape_key_index = 2
        check("'Tube' shows another shape key alone: turn off Shape Key Lock (the pin icon)")
        obj.active_shape_key_index = 1
        self.api.solve(obj)  # the pose alone is fine
        obj.show_only_shape_key = False

        key.relative_key = other
        check("Shape key 'ARAP' of 'Tube' is relative to 'Other': set Relative To to 'Basis'")
        key.relative_key = keys.reference_key

        key.vertex_group = "Half"
        check("Shape key 'ARAP' of 'Tube' is limited to vertex group 'Half': clear that field")
        key.vertex_group = ""

        animated = "The value of shape key 'ARAP' of 'Tube' is animated: delete its keyframes or driver"
        key.keyframe_insert("value", frame=1)
        check(animated)
        keys.animation_data_clear()
        key.driver_add("value")
        check(animated)
        key.driver_remove("value")

        keys.use_relative = False
        check("The shape keys of 'Tube' are absolute: turn on Relative in the shape keys panel")
        keys.use_relative = True
        self.api.solve(obj)

    def test_names_that_cannot_be(self):
        obj = posable()
        self.api.solve(obj)
        obj.arap.key_name = "Basis"
        message = "Shape key 'Basis' of 'Tube' is its rest shape: choose another name for the pose"
        self.assert_error(ValueError, message, self.api.solve, obj)

    def test_shared_mesh_data_is_refused_and_a_fake_user_is_not(self):
        obj = posable()
        obj.data.use_fake_user = True
        self.api.solve(obj)
        other = bpy.data.objects.new("Other", obj.data)
        message = (
            "The mesh of 'Tube' is shared with other objects, which would deform too: make it single-user "
            "(Object > Relations > Make Single User > Object & Data)"
        )
        for function in (self.api.solve, self.api.bake_pose, self.api.reset_pose, self.api.apply_pose_as_rest):
            self.assert_error(ValueError, message, function, obj)
        bpy.data.objects.remove(other)
        self.api.solve(obj)

    def test_linked_data_is_refused(self):
        obj = posable()
        self.api.solve(obj)
        (linked,) = linked_back(obj, "Tube")
        bpy.context.scene.collection.objects.link(linked)
        tail = "linked from another file: make it local (Object > Relations > Make Local)"
        self.assert_error(ValueError, f"'Tube' is {tail}", self.api.solve, linked)
        local = bpy.data.objects.new("Local", linked.data)
        bpy.context.scene.collection.objects.link(local)
        self.assert_error(ValueError, f"The mesh of 'Local' is {tail}", self.api.solve, local)

    def test_library_overrides_are_refused_until_they_are_local(self):
        """Blender saves neither the keys of an override's mesh nor what the add-on keeps in its object."""
        obj = posable()
        self.api.solve(obj)
        self.api.store_pose(obj, "Out")
        tube, head = linked_back(obj, "Tube", "Head")
        override = tube.override_create()
        for item in (override, head):
            bpy.context.scene.collection.objects.link(item)
        override.data = override.data.override_create(remap_local_usages=True)
        bpy.context.view_layer.objects.active = override
        override.select_set(True)
        common = module("ui.checks")
        reason = "a library override, in which a pose is not saved: make it local{} (Object > Relations > Make Local)"
        whole = override.data
        for data in (whole, override.data.copy()):  # of the second the object is one, and its mesh is not
            override.data = data
            n_groups = len(override.vertex_groups)
            for act in (
                self.api.solve,
                lambda obj: self.api.add_pin(obj, [0]),
                lambda obj: self.api.add_handle(obj, [0]),
                lambda obj: self.api.add_rigid(obj, [0]),
                lambda obj: self.api.remove_control(obj, obj.arap.pins[0].name),
                self.api.store_pose,
                lambda obj: self.api.mirror_pose(obj, "Out"),
                lambda obj: self.api.delete_pose(obj, "Out"),
            ):
                self.assert_error(ValueError, f"'Tube' is {reason.format('')}", act, override)
            self.assertEqual(len(override.vertex_groups), n_groups)
            self.assertEqual(common.why_no_mesh(bpy.context), f"This mesh is {reason.format(' first')}")
        override.data = whole
        override.arap.use_follow = True
        self.assertIsNone(module("follow.runs").run_of(override))
        override.arap.use_follow = False
        bpy.ops.object.make_local(type="SELECT_OBDATA")
        self.assertEqual(common.why_no_mesh(bpy.context), "")
        self.api.solve(bpy.context.view_layer.objects.active)
