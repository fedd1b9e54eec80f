# SPDX-License-Identifier: GPL-3.0-or-later
"""The line of the tab that says what to do next, in each state; and that it fits."""

from unittest import mock

import numpy as np
from support import SceneTest, bpy, linked_back, module
from tubes import BOTTOM, MIDDLE, TOP, animate, mesh_object, posable, select_in_edit_mode

MOST_LETTERS = 66  # of four lines in a sidebar of the default width, three in one of 280 pixels


class NextStepTest(SceneTest):
    def setUp(self) -> None:
        super().setUp()
        self.next_step = module("tab.next_step")

    def active_mesh(self, *, is_ready=False):
        obj = posable() if is_ready else mesh_object()
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
        return obj

    def assert_step(self, text, icon="INFO"):
        step = self.next_step.next_step(bpy.context)
        self.assertEqual((step.text, step.icon), (text, icon))
        self.assertLessEqual(len(text), MOST_LETTERS)

    def test_from_nothing_to_a_handle_in_hand(self):
        self.assert_step("Click the mesh to pose in the view.")
        obj = self.active_mesh()
        self.assert_step("Press Pull and drag the mesh. A click on it pins a spot.")
        with mock.patch.object(self.next_step.tool, "is_on", return_value=True):
            self.assert_step("Drag the mesh to pull it. Click it to pin a spot.")
            grab = module("pull.region").PulledPatch
            module("pull.pins").add(obj, [grab(np.array(BOTTOM, dtype=np.int32), 0.0)])
            self.assert_step("Drag the mesh to pull it. Click it to pin a spot.")
            module("pull.pins").add(obj, [grab(np.array(MIDDLE, dtype=np.int32), 1.0)])
            self.assert_step("Pull on. To animate it, press Make Handles (Ctrl H).")
            obj.arap.pull_pins.clear()
        bpy.ops.arap.edit_mesh()
        bpy.ops.mesh.select_all(action="SELECT")
        self.assert_step("All is selected. Drag a box around a part to move or to hold.")
        select_in_edit_mode(obj, TOP)
        self.assert_step("Select a part. Add Handle moves it, Add Pin holds it.")
        bpy.ops.arap.handle_add()
        bpy.ops.arap.edit_mesh()
        self.assert_step("Nothing holds the mesh. Add Pin in Edit Mode does.")
        select_in_edit_mode(obj, BOTTOM)
        bpy.ops.arap.pin_add()
        bpy.ops.arap.edit_mesh()
        self.assert_step("Click a handle in the list. Now G would move the whole object.")
        obj.select_set(False)
        self.assert_step("Click a handle in the list, then press G.")
        obj.arap.active_control_index = 0
        self.assert_step("Move, turn or scale the handle: G, R, S.", "REC")
        obj.arap.use_follow = False
        self.assert_step("Tick Follow, then move a handle: the mesh follows.")
        pull_pins = module("pull.pins")
        pull_pins.add(obj, [module("pull.region").PulledPatch(np.array(MIDDLE, dtype=np.int32), 1.0)])
        self.assert_step("Make Handles (Ctrl H) keeps what you pulled. Then tick Follow.")

    def test_a_pin_alone(self):
        self.api.add_pin(self.active_mesh(), BOTTOM)
        self.assert_step("Press Pull and drag the mesh, or add a handle in Edit Mode.")

    def test_in_other_modes(self):
        self.active_mesh(is_ready=True)
        for mode in ("WEIGHT_PAINT", "SCULPT"):
            bpy.ops.object.mode_set(mode=mode)
            self.assert_step("Go to Object Mode first, in the menu at the top left of the view")
        bpy.ops.object.mode_set(mode="OBJECT")
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)
        bpy.ops.object.armature_add()
        bpy.ops.object.mode_set(mode="POSE")
        self.assert_step("Go to Object Mode first, in the menu at the top left of the view")

    def test_while_posing(self):
        obj = self.active_mesh(is_ready=True)
        posing = module("engine.interaction").Interaction(mock.Mock())
        module("core.sessions").lock(obj, posing)
        self.addCleanup(module("core.sessions").unlock, obj.session_uid, posing)
        self.assert_step("Move a handle (G, R, S). Enter keeps the pose, Esc cancels it.", "REC")
        posing._tracker._binding = mock.Mock()
        with (
            mock.patch.object(type(posing), "phase", module("engine.interaction").Phase.BINDING),
            mock.patch.object(type(posing), "bind_fraction", 0.25),
        ):
            self.assertEqual(self.next_step.next_step(bpy.context).fraction, 0.25)

    def test_after_a_bake(self):
        obj = self.active_mesh(is_ready=True)
        animate(obj)
        self.api.bake_animation(obj, 1, 3)
        self.assert_step("Edit Again shows the pose in place of the bake.")

    def test_what_follow_cannot_do(self):
        obj = self.active_mesh(is_ready=True)
        obj.arap.use_follow = True
        bpy.context.view_layer.update()
        module("follow.runs").run_of(obj).pause = "Paused"
        self.assert_step("Paused", "PAUSE")
        obj.arap.use_follow = False
        obj.arap.follow_error = "Broken"
        self.assert_step("Broken", "ERROR")

    def test_a_deleted_empty_is_told_of_until_it_is_back(self):
        """In the same words while Follow has a problem, and after a pull has forgotten that."""
        obj = self.active_mesh(is_ready=True)
        obj.arap.use_follow = True
        text = "A handle has no own empty: press Copy Handles or remove it."
        bpy.context.scene.collection.objects.unlink(obj.arap.handles[0].target)
        bpy.context.view_layer.update()
        self.assertFalse(obj.arap.use_follow)
        self.assert_step(text, "ERROR")
        obj.arap.follow_error = ""
        self.assert_step(text, "ERROR")
        bpy.ops.arap.handles_copy()
        bpy.context.view_layer.update()
        self.assert_step("Tick Follow, then move a handle: the mesh follows.")

    def test_a_linked_mesh(self):
        (obj,) = linked_back(mesh_object(), "Tube")
        bpy.context.scene.collection.objects.link(obj)
        bpy.context.view_layer.objects.active = obj
        step = self.next_step.next_step(bpy.context)
        self.assertIn("make it local first", step.text)
        self.assertEqual(step.icon, "ERROR")
