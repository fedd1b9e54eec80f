# SPDX-License-Identifier: GPL-3.0-or-later
"""What a newcomer meets: names, reasons, menus, the first pose, preferences, parts that nothing holds."""

import tempfile
from types import SimpleNamespace
from unittest import mock

import numpy as np
from support import (
    BOTTOM,
    TOP,
    FakeAct,
    SceneTest,
    bpy,
    key_positions,
    linked_back,
    mesh_object,
    module,
    move,
    posable,
    unfit,
)

OPERATORS = sorted(name for name in dir(bpy.ops.arap) if not name.startswith("_"))
NOT_IN_THE_MENU = {"pull": "the tool's own key", "pose_end": "a button while a mesh is posed"}


class Layout:
    """Takes what a draw function says, and remembers operators and menus."""

    def __init__(self, said=None) -> None:
        self.said = [] if said is None else said

    def operator(self, name, **_keywords):
        self.said.append(name)
        return SimpleNamespace()

    def menu(self, name, **_keywords):
        self.said.append(name)

    def separator(self):
        pass


def drawn(draw, context=None) -> list[str]:
    layout = Layout()
    draw(SimpleNamespace(layout=layout), context or bpy.context)
    return layout.said


class NamesTest(SceneTest):
    def test_each_act_has_a_name_for_the_search_and_a_tooltip(self):
        self.assertGreater(len(OPERATORS), 15)
        for name in OPERATORS:
            rna = getattr(bpy.ops.arap, name).get_rna_type()
            self.assertIn("ARAP", rna.name, name)
            self.assertGreater(len(rna.description), 20, name)
            self.assertFalse(rna.description.endswith("."), f"{name}: Blender adds the full stop")

    def test_each_property_has_a_name_and_a_tooltip(self):
        groups = [cls.bl_rna for cls in (*module("props.object").CLASSES, module("props.preferences").ArapPreferences)]
        groups += [getattr(bpy.ops.arap, name).get_rna_type() for name in OPERATORS]
        n_seen = 0
        for group in groups:
            for prop in group.properties:
                is_ours = prop.is_runtime and not prop.is_hidden
                n_seen += is_ours
                self.assertTrue(not is_ours or (prop.name and prop.description), f"{group.name}: {prop.identifier}")
        self.assertGreater(n_seen, 40)

    def test_the_menu_has_each_act(self):
        said = {*drawn(bpy.types.ARAP_MT_main.draw), *drawn(bpy.types.ARAP_MT_poses.draw)}
        wanted = {f"arap.{name}" for name in OPERATORS if name not in NOT_IN_THE_MENU}
        self.assertEqual(said, {*wanted, "ARAP_MT_poses"})

    def test_the_menu_is_in_the_menus_of_its_modes(self):
        menus = module("tab.menus")
        for parent, draw in menus.ADDITIONS:
            self.assertIn(draw, getattr(bpy.types, parent).draw._draw_funcs, parent)

    def test_the_menu_of_the_right_button_has_what_its_mode_needs(self):
        obj = mesh_object()
        context_menu = bpy.types.ARAP_MT_context.draw
        for mode, wanted in (
            ("OBJECT", "arap.pose"),
            ("EDIT_MESH", "arap.handle_add"),
            ("PAINT_WEIGHT", "arap.pin_add"),
        ):
            said = drawn(context_menu, SimpleNamespace(mode=mode))
            self.assertIn(wanted, said)
            self.assertTrue(set(said) <= {f"arap.{name}" for name in OPERATORS})
        add = module("tab.menus")._draw_in_context
        self.assertEqual(drawn(add), [], "no mesh is meant")
        bpy.context.view_layer.objects.active = obj
        self.assertEqual(drawn(add), ["ARAP_MT_context"])


class ReasonTest(SceneTest):
    def reason(self, name: str) -> str:
        """Why an act cannot be done."""
        operator = getattr(bpy.ops.arap, name)
        self.assertFalse(operator.poll(), name)
        with self.assertRaises(RuntimeError) as caught:
            operator()
        return str(caught.exception).partition("failed, context is incorrect")[0].partition("poll() ")[2].strip()

    def test_each_act_says_what_it_lacks(self):
        """Nothing is there; then a mesh alone."""
        for name in OPERATORS:
            self.assertGreater(len(self.reason(name)), 10, name)
        bpy.context.view_layer.objects.active = mesh_object()
        for name, wanted in (
            ("solve", "Add a handle first: nothing moves the mesh yet"),
            ("bake_pose", "There is no pose yet: press Pose or Solve first"),
            ("pin_add", "Select vertices in Edit Mode (Tab) to pin them"),
            ("handle_add", "Select vertices in Edit Mode (Tab) to hang them on a handle"),
            ("handle_remove", "Add a handle first: nothing moves the mesh yet"),
            ("reset_handles", "Add a handle first: nothing moves the mesh yet"),
            ("pin_remove", "Add a pin first: nothing is pinned yet"),
            ("stiffness_remove", "Add a stiff group first: nothing is stiffer than the rest yet"),
            ("pull_release", "Pull the mesh with ARAP Pull first, or click it: nothing is pulled or pinned yet"),
            ("select_unheld", "Add a pin or a handle first: nothing holds the mesh yet"),
            ("pose_end", "Press Pose first: this mesh is not being posed"),
        ):
            self.assertIn(wanted, self.reason(name))

    def test_a_mesh_that_is_busy_is_left_alone(self):
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        act = FakeAct("it is solved")
        module("core.sessions").claim(obj.name, act)
        self.addCleanup(module("core.sessions").release, obj.name, act)
        followed = ("handle_remove", "pin_add", "pin_remove", "stiffness_add", "reset_handles", "poses_store")
        for name in ("solve", "bake_animation", "edit_mesh", "select_unheld", *followed):
            self.assertIn("Wait for the mesh: it is solved", self.reason(name))
        module("core.sessions").release(obj.name, act)
        posing = module("follow.act").PoseAct(None)
        module("core.sessions").claim(obj.name, posing)
        self.addCleanup(module("core.sessions").release, obj.name, posing)
        for name in followed:
            self.assertTrue(getattr(bpy.ops.arap, name).poll(), f"{name}: posing follows")
        self.assertIn("End the pose first: Enter keeps it, Esc cancels it", self.reason("solve"))

    def test_what_changes_the_pose_waits_for_a_render(self):
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        self.api.store_pose(obj, "Pose")
        self.api.solve(obj)
        common = module("ui.checks")
        jobs = ("solve", "bake_animation", "export_mesh_cache", "poses_to_keys")
        acts = (*jobs, "bake_pose", "poses_apply", "reset_pose")
        for name in acts:
            self.assertTrue(getattr(bpy.ops.arap, name).poll(), name)
        with mock.patch.object(common, "is_rendering", return_value=True):
            for name in acts:
                self.assertIn("Wait until the render has ended", self.reason(name))

    def test_an_act_that_comes_second_waits(self):
        obj = posable()
        sessions = module("core.sessions")
        self.api.store_pose(obj, "Pose")
        act = FakeAct("it is posed")
        sessions.claim(obj.name, act)
        for begin in (
            lambda: self.api.begin_solve(obj),
            lambda: module("bake.keys").begin_bake(obj, 1, 2),
            lambda: module("poses.keys").begin_pose_keys(obj),
            lambda: module("bake.cache").begin_mesh_cache(obj, "tube.mdd", 1, 2),
        ):
            self.assert_error(RuntimeError, "Wait for 'Tube': it is posed", begin)
        self.assertIs(sessions.acts["Tube"], act)
        sessions.release(obj.name, act)
        job = self.api.begin_solve(obj)
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        sessions.claim("Tube", act)
        job.cancel()
        self.assertIs(sessions.acts["Tube"], act, "of another file")
        sessions.release("Tube", act)

    def test_a_script_waits_for_a_job_and_does_not_disturb_it(self):
        obj = posable()
        move(obj.arap.handles[0].target, (0.5, 0.2, -0.3))
        self.api.solve(obj)
        self.api.store_pose(obj, "Pose")
        shown, state = key_positions(obj), module("pose.result").capture_state(obj)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        for doing, begin in (
            ("it is solved", lambda: self.api.begin_solve(obj)),
            ("it is baked", lambda: module("bake.keys").begin_bake(obj, 1, 2)),
            ("shape keys are made of its poses", lambda: module("poses.keys").begin_pose_keys(obj)),
            (
                "its frames are exported",
                lambda: module("bake.cache").begin_mesh_cache(obj, f"{folder.name}/tube.mdd", 1, 2),
            ),
        ):
            job = begin()
            job.step(0.001)
            for act in (
                self.api.solve,
                module("follow.update").prepare_session,
                module("follow.update").update_pose,
                self.api.reset_pose,
                self.api.apply_pose_as_rest,
                lambda tube: module("pose.result").restore_state(tube, state),
            ):
                self.assert_error(RuntimeError, f"Wait for 'Tube': {doing}", act, obj)
            while job.step():
                pass
            job.cancel()
            np.testing.assert_array_equal(key_positions(obj), shown)
        self.assertEqual(self.api.solve(obj).stop_reason, "converged")

    def test_a_mesh_that_was_renamed_while_it_was_worked_on_does_not_hide_the_selected_one(self):
        obj = mesh_object()
        bpy.context.view_layer.objects.active = None
        obj.select_set(True)
        act = FakeAct("it is solved")
        module("core.sessions").claim("Former", act)
        self.addCleanup(module("core.sessions").release, "Former", act)
        self.assertEqual(module("ui.checks").find_posed_object(bpy.context), obj)


class LinkedTwinTest(SceneTest):
    """A linked object that has the name of a local one is another object."""

    def setUp(self):
        super().setUp()
        other = mesh_object()
        other.scale = (5.0, 5.0, 5.0)
        self.api.add_pin(other, BOTTOM, name="Feet")
        other.vertex_groups["Feet"].remove(BOTTOM)
        bpy.context.view_layer.update()
        (self.linked,) = linked_back(other, "Tube")
        bpy.context.scene.collection.objects.link(self.linked)
        self.obj = posable()
        self.assertEqual((self.obj.name, self.linked.name), ("Tube", "Tube"))

    def test_what_is_remembered_of_one_is_not_told_of_the_other(self):
        depsgraph = bpy.context.evaluated_depsgraph_get()
        size, is_empty = module("scene.mesh_size").diagonal, module("scene.empty_groups").is_empty
        seen = module("pull.seen_mesh").read
        for obj in (self.obj, self.linked):  # the first is remembered where the second is asked for
            size(obj, depsgraph), is_empty(obj, "Feet"), seen(obj, depsgraph)
        self.assertFalse(is_empty(self.obj, "Feet"))
        self.assertTrue(is_empty(self.linked, "Feet"))
        self.assert_close(seen(self.linked, depsgraph).positions, 5.0 * seen(self.obj, depsgraph).positions, 1e-5)
        self.obj.data.update_tag()
        self.obj.update_tag()
        bpy.context.view_layer.update()
        known = module("scene.mesh_size")._known
        self.assertEqual((self.obj.name_full in known, self.linked.name_full in known), (False, True))

    def test_an_act_and_a_readout_are_of_the_local_one(self):
        self.api.solve(self.obj)
        self.assertIsNotNone(module("core.sessions").readout(self.obj.name_full))
        self.assertIsNone(module("core.sessions").readout(self.linked.name_full))
        act = FakeAct("it is solved")
        module("core.sessions").claim("Tube", act)
        self.addCleanup(module("core.sessions").release, "Tube", act)
        common = module("ui.checks")
        self.assertEqual(common.why_busy(self.linked), "")
        self.assertEqual(common.why_busy(self.obj), "Wait for the mesh: it is solved")
        self.assertFalse(module("ui.panels").is_following(self.linked))
        bpy.context.view_layer.objects.active = None
        self.assertEqual(common.find_posed_object(bpy.context), self.obj)


class FirstPoseTest(SceneTest):
    def setUp(self) -> None:
        super().setUp()
        self.first_pose = module("tab.first_pose")

    def done(self, obj) -> list[bool]:
        return [step.is_done for step in self.first_pose.steps(obj)]

    def following(self, obj) -> str:
        return next(step.operator for step in self.first_pose.steps(obj) if not step.is_done)

    def test_five_steps_are_ticked_off_and_each_has_its_button(self):
        self.assertEqual(self.done(None), [False] * 5)
        self.assertTrue(self.first_pose.is_wanted(None))
        obj = mesh_object()
        bpy.context.view_layer.objects.active = obj
        self.assertEqual((self.done(obj), self.following(obj)), ([True, *[False] * 4], "arap.edit_mesh"))
        self.assertEqual(bpy.ops.arap.edit_mesh(), {"FINISHED"})
        self.assertEqual((self.done(obj), self.following(obj)), ([True, True, *[False] * 3], "arap.pin_add"))
        self.select(obj, BOTTOM)
        self.assertEqual(bpy.ops.arap.pin_add(), {"FINISHED"})
        self.assertEqual((self.done(obj), self.following(obj)), ([True] * 3 + [False] * 2, "arap.handle_add"))
        self.select(obj, TOP)
        self.assertEqual(bpy.ops.arap.handle_add(), {"FINISHED"})
        self.assertEqual((self.done(obj), self.following(obj)), ([True] * 4 + [False], "arap.edit_mesh"))
        self.assertEqual(bpy.ops.arap.edit_mesh(), {"FINISHED"})
        self.assertEqual(obj.mode, "OBJECT")
        self.assertEqual((self.done(obj), self.following(obj)), ([True] * 4 + [False], "arap.pose"))
        self.assertTrue(self.first_pose.is_wanted(obj))
        self.api.solve(obj)
        self.assertFalse(self.first_pose.is_wanted(obj))

    def test_a_second_handle_holds_as_well_as_a_pin(self):
        obj = mesh_object()
        self.api.add_handle(obj, TOP)
        self.assertFalse(self.done(obj)[2])
        self.api.add_handle(obj, BOTTOM)
        self.assertTrue(self.done(obj)[2])

    def test_a_mesh_that_is_selected_as_a_whole_is_not_to_be_pinned(self):
        obj = mesh_object()
        bpy.context.view_layer.objects.active = obj
        bpy.ops.arap.edit_mesh()
        hints = {}
        for action in ("SELECT", "DESELECT"):
            bpy.ops.mesh.select_all(action=action)
            hints[action] = self.first_pose.steps(obj)[2].hint
        self.assertIn("All vertices are selected now", hints["SELECT"])
        self.assertIn("First select its vertices", hints["DESELECT"])
        bpy.ops.object.mode_set(mode="OBJECT")

    def test_the_last_step_leads_out_of_each_mode(self):
        obj = mesh_object()
        bpy.context.view_layer.objects.active = obj
        self.api.add_pin(obj, BOTTOM)
        self.api.add_handle(obj, TOP)
        for mode, operator in (
            ("EDIT", "arap.edit_mesh"),
            ("WEIGHT_PAINT", "object.mode_set"),
            ("SCULPT", "object.mode_set"),
            ("OBJECT", "arap.pose"),
        ):
            bpy.ops.object.mode_set(mode=mode)
            step = self.first_pose.steps(obj)[-1]
            self.assertEqual((step.operator, step.mode), (operator, "OBJECT" if operator == "object.mode_set" else ""))
            self.assertEqual(self.first_pose.why_not(bpy.context, step), "", f"the button works in {mode}")

    def test_the_hint_says_what_keeps_its_button_from_working(self):
        obj = mesh_object()
        bpy.context.view_layer.objects.active = obj
        self.api.add_pin(obj, BOTTOM)
        self.api.add_handle(obj, TOP)
        obj.arap.handles[0].is_enabled = False
        step = self.first_pose.steps(obj)[-1]
        self.assertEqual(self.first_pose.why_not(bpy.context, step), "Add a handle first: nothing moves the mesh yet")
        for done in self.first_pose.steps(obj):  # each button has a reason, the very one that makes it grey
            if done.operator in self.first_pose.WHY_NOT and done.operator != "arap.pose":  # posing needs a window
                operator = getattr(bpy.ops.arap, done.operator.removeprefix("arap."))
                self.assertEqual(not self.first_pose.why_not(bpy.context, done), operator.poll(), done.operator)

    def test_the_first_step_says_how_a_mesh_can_be_selected(self):
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)
        bpy.ops.object.armature_add()
        step = self.first_pose.steps(None)[0]
        self.assertEqual(self.first_pose.why_not(bpy.context, step), "")
        for mode, reason in (
            ("EDIT", "Go to Object Mode first (Tab)"),
            ("POSE", "Go to Object Mode first, in the menu at the top left of the view"),
        ):
            bpy.ops.object.mode_set(mode=mode)
            self.assertEqual(self.first_pose.why_not(bpy.context, step), reason)
        bpy.ops.object.mode_set(mode="OBJECT")

    def test_while_posing_the_last_step_is_to_move_the_empty(self):
        obj = posable()
        posing = module("follow.act").PoseAct(None)
        module("core.sessions").claim(obj.name, posing)
        self.addCleanup(module("core.sessions").release, obj.name, posing)
        self.api.add_pin(obj, BOTTOM)
        step = self.first_pose.steps(obj)[-1]
        self.assertEqual((step.text, step.operator, step.is_done), ("Move the empty", "", False))

    def test_the_button_goes_to_the_mesh_also_where_its_handle_is_active(self):
        obj = posable()
        target = obj.arap.handles[0].target
        target.select_set(True)
        bpy.context.view_layer.objects.active = target
        bpy.ops.arap.edit_mesh()
        self.assertEqual((bpy.context.object, obj.mode, target.select_get()), (obj, "EDIT", False))

    def test_a_hidden_mesh_cannot_be_edited(self):
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        obj.hide_set(True)
        for name in ("edit_mesh", "group_select", "group_paint"):
            with self.assertRaises(RuntimeError, msg=name) as caught:
                getattr(bpy.ops.arap, name)()
            self.assertIn("'Tube' is hidden: show it first", str(caught.exception))
        self.assertEqual(obj.mode, "OBJECT")

    def select(self, obj, vertices) -> None:
        bpy.ops.object.mode_set(mode="OBJECT")
        module("scene.meshes").select_vertices(obj, np.asarray(vertices), shows_hidden=True)
        bpy.ops.object.mode_set(mode="EDIT")


class UnheldTest(SceneTest):
    def three_tubes_and_a_loose_vertex(self):
        """The first has a pin and a handle."""
        tubes = [mesh_object(name) for name in ("Tube", "Second", "Third")]
        tubes[1].location.x, tubes[2].location.x = 3.0, 6.0
        loose = bpy.data.meshes.new("Loose")
        loose.from_pydata([(9.0, 0.0, 0.0)], [], [])
        last = bpy.data.objects.new("Loose", loose)
        bpy.context.scene.collection.objects.link(last)
        bpy.context.view_layer.update()
        for obj in (*tubes, last):
            obj.select_set(True)
        bpy.context.view_layer.objects.active = tubes[0]
        bpy.ops.object.join()
        obj = tubes[0]
        self.api.add_pin(obj, BOTTOM)
        self.api.add_handle(obj, TOP)
        return obj

    def test_they_are_found_and_selected(self):
        obj = self.three_tubes_and_a_loose_vertex()
        n = (len(obj.data.vertices) - 1) // 3
        readout = self.api.solve(obj)
        vertices, n_parts = module("scene.unheld").find(obj, bpy.context.evaluated_depsgraph_get())
        self.assertEqual((n_parts, 1), (readout.parts_at_rest, readout.loose_vertices))
        np.testing.assert_array_equal(vertices, np.arange(n, 3 * n + 1))
        text = module("pose.panel").unheld_text(readout)
        self.assertEqual(text, "Held by nothing, so they stay at rest: 2 parts and 1 loose vertices")
        obj.data.vertices[n].hide = True
        self.assertEqual(bpy.ops.arap.select_unheld(), {"FINISHED"})
        self.assertEqual(obj.mode, "EDIT")
        bpy.ops.object.mode_set(mode="OBJECT")
        np.testing.assert_array_equal(module("scene.meshes").selected_vertices(obj), vertices)
        faces = [face for face in obj.data.polygons if face.select]
        self.assertEqual(len(faces), 2 * len(obj.data.polygons) // 3, "whole faces too")

    def test_where_all_is_held_nothing_is_done(self):
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        self.assertEqual(bpy.ops.arap.select_unheld(), {"FINISHED"})
        self.assertEqual(obj.mode, "OBJECT")

    def test_a_pin_that_is_switched_off_holds_nothing(self):
        obj = posable()
        obj.arap.pins[0].is_enabled = obj.arap.handles[0].is_enabled = False
        self.assert_error(
            ValueError,
            "Nothing holds or moves 'Tube': add a pin or a handle",
            module("scene.unheld").find,
            obj,
            bpy.context.evaluated_depsgraph_get(),
        )

    def test_joined_seams_hold_together(self):
        """Two squares that share an edge by place alone."""
        mesh = bpy.data.meshes.new("Seam")
        square = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]
        mesh.from_pydata([*square, *((x + 1.0, y, z) for x, y, z in square)], [], [(0, 1, 2, 3), (4, 5, 6, 7)])
        obj = bpy.data.objects.new("Seam", mesh)
        bpy.context.scene.collection.objects.link(obj)
        bpy.context.view_layer.update()
        self.api.add_pin(obj, [0, 3])
        for is_joined, expected in ((False, 1), (True, 0)):
            obj.arap.join_seams = is_joined
            n_parts = module("scene.unheld").find(obj, bpy.context.evaluated_depsgraph_get())[1]
            self.assertEqual((n_parts, self.api.solve(obj).parts_at_rest), (expected, expected))


class PreferencesTest(SceneTest):
    def setUp(self) -> None:
        super().setUp()
        self.preferences = module("props.preferences")
        addon = bpy.context.preferences.addons[self.preferences.ADDON]
        self.values = addon.preferences
        self.addCleanup(self.restore, {name: self.value(name) for name in type(self.values).__annotations__})

    def value(self, name):
        value = getattr(self.values, name)
        return tuple(value) if name.endswith("_color") else value

    def restore(self, values) -> None:
        for name, value in values.items():
            setattr(self.values, name, value)

    def test_threads_are_those_of_the_session_and_another_number_binds_again(self):
        obj = posable()
        self.values.threads = 2
        first = module("follow.update").prepare_session(obj)
        self.assertEqual(first.settings.threads, 2)
        self.assertIs(module("follow.update").prepare_session(obj), first)
        self.values.threads = 1
        second = module("follow.update").prepare_session(obj)
        self.assertEqual((second.settings.threads, second is first), (1, False))

    def test_the_name_of_the_key_is_for_meshes_that_have_none_of_their_own(self):
        self.values.key_name = "Posed"
        obj, own = posable(), posable("Own")
        own.arap.key_name = "Mine"
        self.api.solve(obj)
        self.api.solve(own)
        self.assertEqual([key.name for key in obj.data.shape_keys.key_blocks], ["Basis", "Posed"])
        self.assertEqual([key.name for key in own.data.shape_keys.key_blocks], ["Basis", "Mine"])
        self.values.key_name = "Later"
        move(obj.arap.handles[0].target, (0.3, 0.0, 0.0))
        self.api.solve(obj)
        self.assertEqual(obj.arap.key_name, "Posed", "the pose stays in the key that it has")
        self.assertEqual(len(obj.data.shape_keys.key_blocks), 2)
        self.assertEqual(module("scene.pose_key").name_of(posable("New")), "Later")
        self.values.key_name = ""
        self.assertEqual(module("scene.pose_key").name_of(mesh_object("Newer")), "ARAP")

    def test_colors_are_the_themes_or_the_chosen_ones(self):
        colors = module("ui.colors")
        theme = bpy.context.preferences.themes[0]
        self.assert_close(colors.of_pins(), (*theme.view_3d.bone_pose[:3], 1.0))
        self.assert_close(colors.of_handles(), (*theme.view_3d.vertex_select[:3], 1.0))
        self.assert_close(colors.of_pull(), (*theme.user_interface.gizmo_primary[:3], 1.0))
        self.values.use_theme_colors = False
        for name, color in (
            ("pin_color", colors.of_pins),
            ("handle_color", colors.of_handles),
            ("pull_color", colors.of_pull),
        ):
            setattr(self.values, name, (0.1, 0.2, 0.3))
            self.assert_close(color(), (0.1, 0.2, 0.3, 1.0))

    def test_the_refine_time_is_that_of_a_step(self):
        self.values.refine_time = 0.2
        self.assert_close(self.preferences.refine_time_s(), 0.2)
        limits = []
        following = module("follow.act").Follower
        original = following.refine
        following.refine = lambda _self, limit: limits.append(limit)
        self.addCleanup(setattr, following, "refine", original)
        obj = posable()
        module("follow.update").prepare_session(obj)
        act = module("follow.act").PoseAct(module("pose.operators").BlenderPoseScene(obj))
        act.begin()
        act.tick(self.preferences.refine_time_s())
        act.tick(self.preferences.refine_time_s())
        self.assert_close(limits, [0.2])

    def test_without_preferences_there_are_defaults(self):
        self.preferences.ADDON, name = "not_there", self.preferences.ADDON
        self.addCleanup(setattr, self.preferences, "__package__", name)
        self.assertEqual((self.preferences.threads(), self.preferences.key_name()), (0, "ARAP"))
        self.assertEqual((self.preferences.refine_time_s(), self.preferences.color("pin_color")), (0.05, None))


class SolveJobTest(SceneTest):
    def run_job(self, job):
        while job.step(0.01):
            pass
        return job.finish()

    def test_it_does_what_solve_does(self):
        obj, other = posable(), posable("Other")
        for each in (obj, other):
            move(each.arap.handles[0].target, (0.5, 0.2, -0.3), (0.4, 0.0, 0.0))
        readout = self.api.solve(obj)
        job = self.api.begin_solve(other)
        self.assertIn("preparing the mesh", job.status)
        self.assertEqual(module("core.sessions").claimed_by("Other"), "it is solved")
        done = self.run_job(job)
        self.assertEqual((done.iterations, done.stop_reason), (readout.iterations, "converged"))
        np.testing.assert_array_equal(key_positions(other), key_positions(obj))
        self.assertEqual(module("core.sessions").claimed_by("Other"), "")
        self.assertEqual(unfit(other, is_thorough=True), "")
        self.assertEqual(self.run_job(self.api.begin_solve(other)).iterations, readout.iterations, "bound already")

    def test_cancelled_it_leaves_everything_and_the_bind(self):
        obj = posable()
        move(obj.arap.handles[0].target, (0.5, 0.2, -0.3))
        self.api.solve(obj)
        before, session = key_positions(obj), module("core.sessions").get("Tube").session
        move(obj.arap.handles[0].target, (0.5, 0.0, 0.0))
        for has_started in (False, True):
            job = self.api.begin_solve(obj)
            if has_started:
                job.step(0.0)
            job.cancel()
            np.testing.assert_array_equal(key_positions(obj), before)
            self.assertIs(module("core.sessions").get("Tube").session, session)
            self.assertEqual(module("core.sessions").claimed_by("Tube"), "")
        self.assertEqual(self.api.solve(obj).stop_reason, "converged")

    def test_what_happens_to_the_mesh_meanwhile_ends_it(self):
        obj = posable()
        job = self.api.begin_solve(obj)
        while job.step(0.01):
            pass
        obj.name = "Renamed"
        self.assert_error(RuntimeError, "'Tube' is not there any more: there is nothing to pose", job.finish)
        job.cancel()
        obj.name = "Tube"
        job = self.api.begin_solve(obj)
        while job.step(0.01):
            pass
        obj.data.vertices.add(1)
        with self.assertRaises(RuntimeError) as caught:
            job.finish()
        self.assertIn("while it was solved: solve again", str(caught.exception))
        job.cancel()
        self.assertIsNone(obj.data.shape_keys)

    def test_what_solve_refuses_it_refuses_too(self):
        obj = mesh_object()
        message = "Nothing holds or moves 'Tube': add a pin or a handle"
        self.assert_error(ValueError, message, self.api.begin_solve, obj)
        self.assertEqual(module("core.sessions").claimed_by("Tube"), "")
