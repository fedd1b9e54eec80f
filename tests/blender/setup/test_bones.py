# SPDX-License-Identifier: GPL-3.0-or-later
"""Bones that move what they pass through inside the mesh, without vertex groups."""

import bmesh
import numpy as np
from looks import key_positions, rest_positions, shown_positions
from mathutils import Matrix
from support import SceneTest, bpy, module
from tubes import BALL, BOTTOM, TOP, empty_at, mesh_object, with_balls

HALF = 2.0


def arm(obj, names=("Lower", "Upper"), x=0.0):
    """An armature with a chain of two bones along the tube, in the space of the object."""
    data = bpy.data.armatures.new("Arm")
    armature = bpy.data.objects.new("Arm", data)
    bpy.context.scene.collection.objects.link(armature)
    armature.matrix_world = obj.matrix_world
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    for i, name in enumerate(names):
        bone = data.edit_bones.new(name)
        bone.head, bone.tail = (x, 0.0, 0.1 + 1.9 * i), (x, 0.0, 2.0 + 1.9 * i)
        if i:
            bone.parent = data.edit_bones[names[i - 1]]
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    return armature


def remove_faces(obj, indices):
    mesh = bmesh.new()
    mesh.from_mesh(obj.data)
    mesh.faces.ensure_lookup_table()
    bmesh.ops.delete(mesh, geom=[mesh.faces[i] for i in indices], context="FACES_ONLY")
    mesh.to_mesh(obj.data)
    mesh.free()


def bend(armature, name, angle):
    bone = armature.pose.bones[name]
    bone.rotation_mode = "XYZ"
    bone.rotation_euler = (angle, 0.0, 0.0)
    bpy.context.view_layer.update()


def bent(points, angle):
    """About the x axis through the joint: as a bone along z turns by its own x, which is that of the armature."""
    turn = np.array(Matrix.Rotation(angle, 3, "X"))
    joint = np.array([0.0, 0.0, HALF])
    return (points - joint) @ turn.T + joint


class BonesTest(SceneTest):
    def assert_bent(self, obj, positions, angle):
        rest = rest_positions(obj)
        self.assert_close(positions[BOTTOM], rest[BOTTOM], 0.06)
        self.assert_close(positions[TOP], bent(rest[TOP], angle), 0.06)

    def test_bones_move_the_mesh_and_make_it_solid(self):
        obj = mesh_object()
        armature = arm(obj)
        self.assertEqual(self.api.add_bones(obj, armature), ["Lower", "Upper"])
        self.assertEqual([control.kind for control in obj.arap.controls], ["bone", "bone"])
        self.assertEqual((obj.arap.model, len(obj.vertex_groups)), ("solid", 0))
        bend(armature, "Upper", 1.0)
        self.api.solve(obj)
        self.assert_bent(obj, key_positions(obj), 1.0)

    def test_the_mesh_at_rest_has_the_armature_in_its_rest_position(self):
        obj = mesh_object()
        armature = arm(obj)
        bend(armature, "Upper", 0.8)
        self.api.add_bones(obj, armature)
        self.api.solve(obj)
        self.assert_bent(obj, key_positions(obj), 0.8)
        self.assertEqual(self.api.reset_handles(obj), [])
        self.api.solve(obj)
        self.assert_close(key_positions(obj), rest_positions(obj), 1e-4)

    def test_they_work_in_follow_playback_and_bakes_with_handles_and_pins_beside(self):
        obj = mesh_object()
        armature = arm(obj)
        self.api.add_pin(obj, BOTTOM, name="Feet")
        self.api.add_bones(obj, armature, ["Upper"])
        obj.arap.use_follow = True
        bpy.context.view_layer.update()
        bend(armature, "Upper", 0.6)
        self.assertEqual((obj.arap.use_follow, obj.arap.follow_error), (True, ""))
        rest = rest_positions(obj)
        self.assert_close(shown_positions(obj)[TOP], bent(rest[TOP], 0.6), 0.06)
        self.assert_close(shown_positions(obj)[BOTTOM], rest[BOTTOM], 1e-5)
        obj.arap.use_follow = False
        bone = armature.pose.bones["Upper"]
        for frame, angle in ((1, 0.0), (11, 1.0)):
            bone.rotation_euler = (angle, 0.0, 0.0)
            bone.keyframe_insert("rotation_euler", frame=frame)
        for name, angle in zip(self.api.bake_animation(obj, 1, 11, 10), (0.0, 1.0), strict=True):
            self.assert_close(key_positions(obj, name)[TOP], bent(rest[TOP], angle), 0.06)
            self.assert_close(key_positions(obj, name)[BOTTOM], rest[BOTTOM], 1e-5)

    def test_stretched_and_turned_objects(self):
        obj = mesh_object(matrix=Matrix.Translation((3.0, -2.0, 1.0)) @ Matrix.Diagonal((1.0, 1.0, 2.0, 1.0)))
        armature = arm(obj)
        self.api.add_bones(obj, armature)
        self.api.solve(obj)
        self.assert_close(key_positions(obj), rest_positions(obj), 1e-4)

    def test_a_bone_outside_moves_nothing_and_is_told(self):
        obj = mesh_object()
        armature = arm(obj)
        far = arm(obj, ("Far",), x=3.0)
        self.api.add_bones(obj, armature)
        self.api.add_bones(obj, far)
        bend(far, "Far", 1.0)
        stats = self.api.solve(obj)
        self.assertEqual(stats.outside, ("Far",))
        self.assert_close(key_positions(obj), rest_positions(obj), 1e-4)
        for index in (0, 1):
            obj.arap.handles[index].is_enabled = False
        self.assert_error(
            ValueError,
            "No bone passes through the mesh (Far): move the armature into it, then press Add Bones again",
            self.api.solve,
            obj,
        )

    def test_add_bones_again_reads_the_rest_position_again(self):
        obj = mesh_object()
        far = arm(obj, x=3.0)
        self.api.add_bones(obj, far, ["Upper", "Upper"])
        with self.assertRaisesRegex(ValueError, r"^No bone passes through the mesh \(Upper\)"):
            self.api.solve(obj)
        far.location.x -= 3.0
        bpy.context.view_layer.update()
        self.assertEqual(self.api.add_bones(obj, far), ["Upper", "Lower"])
        self.assertEqual(len(obj.arap.handles), 2)
        stats = self.api.solve(obj)
        self.assertEqual(stats.outside, ())
        self.assert_close(key_positions(obj), rest_positions(obj), 1e-4)

    def test_a_bone_that_is_cleared_or_of_no_armature_is_told(self):
        obj = mesh_object()
        rig = arm(obj)
        self.api.add_bones(obj, rig, ["Upper"])
        bone = obj.arap.controls["Upper"]
        for field, value, reason in (
            ("bone", "", "it has no bone; choose one or remove it"),
            ("target", empty_at((0.0, 0.0, 1.0)), "it has no bone; choose one or remove it"),
            ("bone", "Upper", "'Empty' is not an armature and has no bones; clear the bone"),
            ("target", rig, ""),
        ):
            setattr(bone, field, value)
            problem = module("setup.controls").control_problem(obj, bone)
            self.assertEqual(problem, f"Bone 'Upper' of 'Tube': {reason}" if reason else "")
        self.assert_close(module("scene.handle_motion").handle_matrices(obj)[0], np.eye(4), 1e-5)

    def test_the_fields_of_an_entry_may_be_set_in_any_order(self):
        obj = mesh_object()
        rig = arm(obj, x=0.3)
        obj.arap.model = "solid"
        bone = obj.arap.controls.add()
        bone.target, bone.bone, bone.kind = rig, "Upper", "bone"
        self.assert_close(module("scene.handle_motion").handle_matrices(obj)[0], np.eye(4), 1e-5)

    def test_the_twin_of_a_bone_in_the_other_half_holds_nothing(self):
        obj = mesh_object()
        obj.data.transform(Matrix.Rotation(1.5707963, 4, "Y"))  # along x, from the plane
        modifier = obj.modifiers.new("Mirror", "MIRROR")
        modifier.use_clip = True
        remove_faces(obj, [face.index for face in obj.data.polygons if abs(face.center.x) < 1e-4])
        armature = arm(obj)
        armature.data.transform(Matrix.Rotation(1.5707963, 4, "Y"))
        twin = arm(obj, ("Lower.R", "Upper.R"))
        twin.data.transform(Matrix.Rotation(-1.5707963, 4, "Y"))
        bpy.context.view_layer.update()
        self.api.add_bones(obj, armature)
        bend(armature, "Upper", 0.8)
        self.api.solve(obj)
        alone = key_positions(obj)
        self.api.add_bones(obj, twin)
        stats = self.api.solve(obj)
        self.assertEqual(set(stats.outside), {"Lower.R", "Upper.R"})
        self.assert_close(key_positions(obj), alone, 1e-4)

    def test_parts_that_no_bone_passes_through_are_selected_as_unheld(self):
        obj = with_balls((5.0, 0.0, 2.0))
        obj.arap.use_loose_parts = False
        self.api.remove_control(obj, obj.arap.handles[0].name)
        self.api.remove_control(obj, obj.arap.pins[0].name)
        self.api.add_bones(obj, arm(obj))
        find = module("setup.free_parts").find
        with self.assertRaisesRegex(ValueError, "is known once it was posed"):
            find(obj, bpy.context.evaluated_depsgraph_get())
        self.api.prepare_session(obj)
        self.api.update_pose(obj)
        vertices, n_parts = find(obj, bpy.context.evaluated_depsgraph_get())
        self.assertEqual((n_parts, len(vertices)), (1, BALL))

    def test_what_cannot_be_is_refused_and_nothing_changes(self):
        obj = mesh_object()
        armature = arm(obj)
        add = self.api.add_bones
        self.assert_error(ValueError, "'Tube' cannot take the bones: choose an armature", add, obj, obj)
        self.assert_error(
            ValueError,
            "'Tube' cannot take the bones: armature 'Arm' has no bone 'Hand'; choose another bone",
            add,
            obj,
            armature,
            ["Lower", "Hand"],
        )
        modifier = obj.modifiers.new("Armature", "ARMATURE")
        modifier.object = armature
        message = (
            "'Tube' cannot take the bones: modifier 'Armature' moves the mesh with bone 'Lower' already; remove it or "
            "switch it off, in viewports and renders, or take a bone that does not deform"
        )
        for modifier.show_viewport in (True, False):  # off in viewports alone it still moves the render
            self.assert_error(ValueError, message, add, obj, armature)
        self.assertEqual((len(obj.arap.handles), obj.arap.model), (0, "surface"))
        modifier.show_render = False
        add(obj, armature)
        obj.arap.model = "surface"
        why = "a bone moves what is inside of a solid; choose Model: Solid"
        message = f"Bone 'Lower' of 'Tube': {why}. Bone 'Upper' of 'Tube': {why}"
        self.assert_error(ValueError, message, self.api.solve, obj)

    def test_the_operator_takes_the_selected_armature_or_the_selected_bones(self):
        obj = mesh_object()
        armature = arm(obj)
        bpy.ops.object.select_all(action="DESELECT")
        self.assertFalse(bpy.ops.arap.bones_add.poll())
        obj.select_set(True)
        armature.select_set(True)
        bpy.context.view_layer.objects.active = armature
        bpy.ops.object.mode_set(mode="POSE")
        bpy.ops.pose.select_all(action="DESELECT")
        self.assertFalse(bpy.ops.arap.bones_add.poll())
        module("scene.versions").select_bone(armature, "Upper")
        bpy.ops.arap.bones_add()
        self.assertEqual([handle.bone for handle in obj.arap.handles], ["Upper"])
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.context.view_layer.objects.active = obj
        bpy.ops.arap.bones_add()
        self.assertEqual([handle.bone for handle in obj.arap.handles], ["Upper", "Lower"])
        self.assertTrue(obj.arap.use_follow)

    def test_a_pull_beside_posed_bones_leaves_them_where_they_are(self):
        obj = mesh_object()
        armature = arm(obj)
        self.api.add_bones(obj, armature)
        bend(armature, "Upper", 0.7)
        self.api.solve(obj)
        posed = key_positions(obj)
        region = module("pull.region")
        grab = region.PulledPatch(np.array(TOP[:1], dtype=np.int32), 0.0)
        pull = module("pull.hold").begin_pull(obj, bpy.context.evaluated_depsgraph_get(), [grab])
        run, session = module("core.background").run, module("core.session").Session
        bound = run(
            session.bind(module("core.native").load(), pull.inputs.mesh, pull.inputs.stretch, pull.inputs.settings)
        )
        run(bound.set_handles(pull.inputs.specs))
        bound.set_positions(posed)
        bound.update(pull.matrices(np.eye(4), np.eye(4)), to_convergence=True)
        self.assert_close(bound.positions, posed, 0.02)
