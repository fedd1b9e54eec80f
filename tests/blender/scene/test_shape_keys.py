# SPDX-License-Identifier: GPL-3.0-or-later
"""The key that takes the pose: what is made, what is left alone, what is refused."""

import tempfile
from pathlib import Path

import numpy as np
import support
from support import (
    TOP,
    SceneTest,
    bend,
    bpy,
    key_positions,
    linked_back,
    mesh_object,
    module,
    move,
    posable,
    rest_positions,
    shown_positions,
)


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

    def test_the_name_of_the_key_can_be_chosen(self):
        obj = posable()
        obj.arap.key_name = "Bent"
        bend(obj)
        self.api.solve(obj)
        self.assertEqual([key.name for key in obj.data.shape_keys.key_blocks], ["Basis", "Bent"])

    def test_a_slider_that_was_moved_is_set_again(self):
        obj = posable()
        self.api.solve(obj)
        key = obj.data.shape_keys.key_blocks["ARAP"]
        key.value, key.slider_max = 0.2, 0.5
        self.api.solve(obj)
        self.assertEqual(key.value, 1.0)

    def test_other_keys_stay_and_add_on_top(self):
        obj = mesh_object()
        obj.shape_key_add(name="Basis")
        smile = obj.shape_key_add(name="Smile")
        for point in smile.data:
            point.co.x += 0.25
        smile.value = 1.0
        api = self.api
        api.add_pin(obj, range(8))
        handle = api.add_handle(obj, TOP)
        bpy.context.view_layer.update()
        before = key_positions(obj, "Smile")
        move(handle.target, (0.0, 0.5, 0.0))
        api.solve(obj)
        self.assert_close(key_positions(obj, "Smile"), before, 0.0)
        self.assertEqual(smile.value, 1.0)
        self.assert_close(shown_positions(obj), key_positions(obj) + np.array([0.25, 0.0, 0.0]), 1e-5)

    def test_subdivision_and_armature_after_the_key_deform_the_posed_mesh(self):
        obj = posable()
        bend(obj)
        self.api.solve(obj)
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
            "Shape key 'ARAP' of 'Tube' is muted (a bake does that), so the pose would not show: "
            "unmute it, and mute or remove the baked keys"
        )
        check(muted)
        check(muted, self.api.update_pose)
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
            self.assert_error(ValueError, f"'Tube' is {reason.format('')}", self.api.solve, override)
            self.assertEqual(common.why_no_mesh(bpy.context), f"This mesh is {reason.format(' first')}")
        override.data = whole
        override.arap.is_live = True
        self.assertIsNone(module("live.runs").run_of(override))
        override.arap.is_live = False
        bpy.ops.object.make_local(type="SELECT_OBDATA")
        self.assertEqual(common.why_no_mesh(bpy.context), "")
        self.api.solve(bpy.context.view_layer.objects.active)


class LiveKeyTest(SceneTest):
    """The key of the pose is one that was made for it; a key of the artist's own that has its name is not."""

    def own_key(self, obj, name="ARAP"):
        if obj.data.shape_keys is None:
            obj.shape_key_add(name="Basis")
        key = obj.shape_key_add(name=name)
        for point in key.data:
            point.co.x += 0.25
        key.value = 0.5
        return key_positions(obj, name)

    def names(self, obj):
        return [key.name for key in obj.data.shape_keys.key_blocks]

    def test_a_key_that_has_the_name_already_is_left_alone(self):
        obj = posable()
        mine = self.own_key(obj)
        bend(obj)
        for _ in range(2):
            self.api.solve(obj)
            self.assertEqual(self.names(obj), ["Basis", "ARAP", "ARAP.001"])
            self.assertEqual(obj.arap.key_name, "ARAP.001")
        self.api.prepare_session(obj)
        self.api.update_pose(obj)
        self.assertEqual(self.api.bake_pose(obj, "Bent").name, "Bent")
        self.assert_close(key_positions(obj, "Bent"), key_positions(obj, "ARAP.001"), 0.0)
        self.api.reset_pose(obj)
        self.assert_close(key_positions(obj, "ARAP.001"), rest_positions(obj), 0.0)
        self.api.bake_animation(obj, 1, 2)
        keys = obj.data.shape_keys.key_blocks
        self.assertEqual((keys["ARAP"].mute, keys["ARAP.001"].mute), (False, True))
        self.assert_close(key_positions(obj, "ARAP"), mine, 0.0)
        self.assertEqual(keys["ARAP"].value, 0.5)

    def test_it_is_no_pose_either(self):
        obj = posable()
        self.own_key(obj)
        for function in (self.api.bake_pose, self.api.apply_pose_as_rest):
            self.assert_error(ValueError, "'Tube' has no pose yet: pose it first", function, obj)
        mine = key_positions(obj)
        self.api.reset_pose(obj)
        self.assert_close(key_positions(obj), mine, 0.0)
        target = self.api.add_handle(obj, [40], name="More").target
        self.assert_close(target.matrix_world.translation, rest_positions(obj)[40], 1e-6)

    def test_the_next_free_name_is_taken(self):
        obj = posable()
        for name in ("ARAP", "ARAP.001", "ARAP.003"):
            self.own_key(obj, name)
        self.api.solve(obj)
        self.assertEqual(self.names(obj)[-1], "ARAP.002")
        long = "x" * 63
        self.own_key(obj, long)
        obj.arap.key_name = long + "yz"
        self.api.solve(obj)
        self.assertEqual((self.names(obj)[-1], obj.arap.key_name), ("x" * 57 + ".001",) * 2)

    def test_keys_made_before_are_continued(self):

        obj = posable()
        for name in ("ARAP", "Bent", "ARAP", "Bent"):
            obj.arap.key_name = name
            self.api.solve(obj)
            obj.data.shape_keys.key_blocks[name].value = 0.0
        self.assertEqual(self.names(obj), ["Basis", "ARAP", "Bent"])
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "saved.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
        obj = bpy.data.objects["Tube"]
        copy = obj.copy()
        copy.data = obj.data.copy()
        bpy.context.scene.collection.objects.link(copy)
        bpy.context.view_layer.update()
        for item in (obj, copy):
            self.api.solve(item)
            self.assertEqual(self.names(item), ["Basis", "ARAP", "Bent"])

    def test_the_state_before_gives_the_name_back(self):
        obj = posable()
        mine = self.own_key(obj)
        state = self.api.capture_state(obj)
        self.api.solve(obj)
        self.api.restore_state(obj, state)
        self.assertEqual((self.names(obj), obj.arap.key_name), (["Basis", "ARAP"], "ARAP"))
        self.assert_close(key_positions(obj), mine, 0.0)
        self.api.solve(obj)
        self.assertEqual(self.names(obj), ["Basis", "ARAP", "ARAP.001"])

    def test_a_name_of_a_key_that_was_removed_is_free_again(self):
        obj = posable()
        self.api.solve(obj)
        obj.shape_key_remove(obj.data.shape_keys.key_blocks["ARAP"])
        module("scene.pose_key").forget_removed(obj)
        self.own_key(obj)
        self.api.solve(obj)
        self.assertEqual(self.names(obj), ["Basis", "ARAP", "ARAP.001"])

    def test_a_bake_keeps_the_name_that_it_has_taken_from_the_preferences(self):
        obj = posable()
        names = self.api.bake_animation(obj, 1, 2)
        values = bpy.context.preferences.addons[support.PACKAGE].preferences
        self.addCleanup(setattr, values, "key_name", values.key_name)
        values.key_name = "Posed"
        self.assertEqual(self.api.bake_animation(obj, 1, 2), names)


class ResultTest(SceneTest):
    def test_bake_pose_keeps_a_copy_at_value_zero(self):
        obj = posable()
        bend(obj)
        self.api.solve(obj)
        posed = key_positions(obj)
        key = self.api.bake_pose(obj, name="Wave")
        self.assertEqual((key.name, key.value), ("Wave", 0.0))
        self.assert_close(key_positions(obj, "Wave"), posed, 0.0)
        self.assertEqual(self.api.bake_pose(obj, name="Wave").name, "Wave.001")
        self.api.reset_handles(obj)
        self.api.solve(obj)
        self.assert_close(key_positions(obj, "Wave"), posed, 0.0)
        self.assert_error(
            ValueError, "The baked pose needs a name: type one, for example Pose", self.api.bake_pose, obj, ""
        )

    def test_what_becomes_of_a_pose_is_what_is_shown(self):
        obj = posable()
        bend(obj)
        self.api.solve(obj)
        rest, posed = rest_positions(obj), key_positions(obj)
        key = obj.data.shape_keys.key_blocks["ARAP"]
        key.mute = True
        message = (
            "Shape key 'ARAP' of 'Tube' is muted (a bake does that), so the pose would not show: "
            "unmute it, and mute or remove the baked keys"
        )
        for function in (self.api.bake_pose, self.api.apply_pose_as_rest):
            self.assert_error(ValueError, message, function, obj)
        key.mute = False
        key.value = 0.5
        half = rest + 0.5 * (posed - rest)
        on_pose = obj.shape_key_add(name="On pose")
        on_pose.value = 0.0
        on_pose.relative_key = key
        for point, place in zip(on_pose.data, posed, strict=True):
            point.co = place
            point.co.y += 0.5
        self.api.bake_pose(obj, name="Half")
        self.assert_close(key_positions(obj, "Half"), half, 1e-6)
        self.assert_close(shown_positions(obj), half, 1e-6)
        self.api.apply_pose_as_rest(obj)
        self.assert_close(key_positions(obj, "Basis"), half, 1e-6)
        self.assert_close(key_positions(obj), half, 1e-6)
        self.assert_close(shown_positions(obj), half, 1e-6)
        self.assert_close(key_positions(obj, "On pose"), half + np.array([0.0, 0.5, 0.0]), 1e-5)

    def test_what_needs_a_pose_says_so(self):
        obj = posable()
        message = "'Tube' has no pose yet: pose it first"
        self.assert_error(ValueError, message, self.api.bake_pose, obj)
        self.assert_error(ValueError, message, self.api.apply_pose_as_rest, obj)
        self.api.reset_pose(obj)
        self.assertIsNone(obj.data.shape_keys)

    def test_reset_pose_goes_back_to_rest_and_leaves_the_handles(self):
        obj = posable()
        bend(obj)
        self.api.solve(obj)
        place = obj.arap.handles[0].target.matrix_world.copy()
        self.api.reset_pose(obj)
        self.assert_close(key_positions(obj), rest_positions(obj), 0.0)
        self.assertEqual(obj.arap.handles[0].target.matrix_world, place)
        self.assert_close(self.api.prepare_session(obj).positions, rest_positions(obj), 1e-6)

    def test_apply_pose_as_rest(self):
        obj = posable()
        smile = obj.shape_key_add(name="Basis") and obj.shape_key_add(name="Smile")
        for point in smile.data:
            point.co.x += 0.25
        smile.value = 0.0
        bend(obj)
        self.api.solve(obj)
        on_pose = self.api.bake_pose(obj, name="On pose")
        on_pose.relative_key = obj.data.shape_keys.key_blocks["ARAP"]
        for point in on_pose.data:
            point.co.y += 0.5
        posed = key_positions(obj)
        shown = shown_positions(obj)
        self.api.apply_pose_as_rest(obj)
        self.assert_close(key_positions(obj, "Basis"), posed, 0.0)
        self.assert_close(key_positions(obj), posed, 0.0)
        self.assert_close(key_positions(obj, "Smile"), posed + np.array([0.25, 0.0, 0.0]), 1e-5)
        self.assert_close(key_positions(obj, "On pose"), posed + np.array([0.0, 0.5, 0.0]), 1e-5)
        self.assert_close(shown_positions(obj), shown, 1e-5)
        self.assert_close(module("scene.versions").read_positions(obj.data), posed, 0.0)
        self.assert_close(self.api.handle_matrices(obj), np.tile(np.eye(4), (2, 1, 1)), 1e-6)
        self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, 4e-6)
        self.api.reset_handles(obj)
        self.assert_close(self.api.handle_matrices(obj), np.tile(np.eye(4), (2, 1, 1)), 1e-5)

    def test_state_brings_back_key_slider_and_handles(self):
        obj = posable()
        bend(obj)
        self.api.solve(obj)
        key = obj.data.shape_keys.key_blocks["ARAP"]
        key.slider_max = 0.5
        key.value = 0.4
        target = obj.arap.handles[0].target
        parent = bpy.data.objects.new("Parent", None)
        self.scene.collection.objects.link(parent)
        target.parent = parent
        state = self.api.capture_state(obj)
        before = key_positions(obj), target.matrix_basis.copy(), parent.matrix_basis.copy()
        move(target, (1.0, 1.0, 1.0), (0.3, 0.2, 0.1))
        parent.location = (1.0, 2.0, 3.0)
        bpy.context.view_layer.update()
        self.api.solve(obj)
        self.api.restore_state(obj, state)
        self.assert_close(key_positions(obj), before[0], 0.0)
        self.assertAlmostEqual(key.value, 0.4, places=6)
        self.assertEqual(key.slider_max, 0.5)
        self.assertEqual((target.matrix_basis, parent.matrix_basis), before[1:])
        self.assert_close(self.api.prepare_session(obj).positions, before[0], 1e-6)

    def test_state_without_a_key_leaves_none(self):
        for has_keys in (False, True):
            obj = posable(f"Tube{has_keys}")
            rest = rest_positions(obj)
            if has_keys:
                obj.shape_key_add(name="Basis")
            state = self.api.capture_state(obj)
            bend(obj)
            self.api.solve(obj)
            self.api.restore_state(obj, state)
            keys = obj.data.shape_keys
            self.assertEqual([key.name for key in keys.key_blocks] if keys else None, ["Basis"] if has_keys else None)
            self.assert_close(shown_positions(obj), rest, 1e-6)

    def test_state_brings_back_the_active_key(self):
        obj = posable()
        for name in ("Basis", "Smile", "Frown"):
            obj.shape_key_add(name=name).value = 0.0
        for name in ("Smile", "Frown"):
            obj.active_shape_key_index = obj.data.shape_keys.key_blocks.find(name)
            for _ in range(2):  # without the live key, then with it
                state = self.api.capture_state(obj)
                self.api.solve(obj)
                obj.active_shape_key_index = obj.data.shape_keys.key_blocks.find("ARAP")
                self.api.restore_state(obj, state)
                self.assertEqual(obj.active_shape_key.name, name)
                self.api.solve(obj)
            module("scene.shape_keys").remove(obj, "ARAP")
            self.assertEqual(obj.active_shape_key.name, name)

    def test_state_of_another_mesh_is_refused_but_the_handles_go_back(self):
        obj = posable()
        self.api.solve(obj)
        state = self.api.capture_state(obj)
        target = obj.arap.handles[0].target
        before = target.matrix_basis.copy()
        bend(obj)
        obj.shape_key_clear()
        obj.data.clear_geometry()
        message = "'Tube' has 0 vertices, but had 136: its shape key stays"
        self.assert_error(ValueError, message, self.api.restore_state, obj, state)
        self.assertEqual(target.matrix_basis, before)

    def test_state_passes_over_what_is_gone(self):
        obj = posable()
        state = self.api.capture_state(obj)
        bpy.data.objects.remove(obj.arap.handles[0].target)
        self.api.restore_state(obj, state)
