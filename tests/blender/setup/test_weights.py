# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights of groups: soft and hard, several groups; soft edges; what follows when they change."""

from types import SimpleNamespace
from unittest import mock

import numpy as np
from looks import key_positions, rest_positions
from mathutils import Matrix
from support import SceneTest, bpy, module, uid
from tubes import BOTTOM, MIDDLE, TOP, bend, mesh_object, posable, solved


def problem_of_head(obj):
    return module("setup.controls").control_problem(obj, obj.arap.handles[0], with_weights=True)


class WeightTest(SceneTest):
    def test_a_group_without_weights_is_told_before_it_is_solved(self):
        obj = posable()
        group = obj.vertex_groups.new(name="Empty")
        message = (
            "Handle 'Head' of 'Tube': vertex group 'Empty' has no weights; assign vertices to it or remove the handle"
        )

        def problem():
            bpy.context.view_layer.update()
            return problem_of_head(obj)

        self.assertEqual(problem(), "")
        obj.arap.handles[0].vertex_group = "Empty"
        self.assertEqual(problem(), message)
        self.assert_error(ValueError, message, self.api.solve, obj)
        for weight, wanted in ((0.5, ""), (0.0, message)):
            group.add(TOP, weight, "REPLACE")
            self.assertEqual(problem(), wanted)
        bpy.context.view_layer.objects.active = obj
        for mode, wanted in (("EDIT", ""), ("OBJECT", message)):  # not told while the mesh is edited
            bpy.ops.object.mode_set(mode=mode)
            self.assertEqual(problem(), wanted)
        obj.vertex_groups["Empty"].name = obj.arap.handles[0].vertex_group = "Renamed"
        self.assertEqual(problem(), message.replace("Empty", "Renamed"))
        obj.arap.pins[0].vertex_group = "Renamed"
        self.api.remove_control(obj, "Head")
        message = "No vertex is pinned or has a handle: add a pin or a handle, or give its group weight"
        self.assert_error(ValueError, message, self.api.solve, obj)

    def test_an_undo_brings_the_weights_back_for_the_panel_too(self):
        obj = posable()
        self.assertEqual(problem_of_head(obj), "")
        bpy.ops.ed.undo_push(message="weights")
        obj.vertex_groups["Head"].remove(TOP)
        bpy.context.view_layer.update()
        self.assertIn("has no weights", problem_of_head(obj))
        bpy.ops.ed.undo_push(message="none")
        bpy.ops.ed.undo()
        self.assertEqual(problem_of_head(bpy.data.objects["Tube"]), "")

    def test_follow_takes_weights_without_a_bind_in_weight_paint_too(self):
        sessions = module("core.sessions")
        obj = posable()
        self.api.add_pin(obj, MIDDLE, name="Waist")
        obj.arap.use_follow = True
        bend(obj)
        held = key_positions(obj)[MIDDLE]
        self.assert_close(held, rest_positions(obj)[MIDDLE])
        bpy.context.view_layer.objects.active = obj
        session = sessions.get(uid("Tube")).session
        for mode in ("OBJECT", "WEIGHT_PAINT"):
            bpy.ops.object.mode_set(mode=mode)
            for weight in (0.2, 1.0):
                obj.vertex_groups["Waist"].add(MIDDLE, weight, "REPLACE")
                obj.data.update_tag()
                bpy.context.view_layer.update()
                self.assertIs(sessions.get(uid("Tube")).session, session)
                is_held = np.abs(key_positions(obj) - rest_positions(obj))[MIDDLE].max() < 1e-4
                self.assertEqual((is_held, obj.arap.follow_error), (weight == 1.0, ""))

    def followed(self, obj):
        """Its EngineScene, told of evaluations as an act's is."""
        scene = module("pose.scene").InteractionScene(obj)

        def tell(_scene, depsgraph):
            with scene.evaluated(depsgraph, module("scene.known").updates(depsgraph)):
                pass

        bpy.app.handlers.depsgraph_update_post.append(tell)
        self.addCleanup(bpy.app.handlers.depsgraph_update_post.remove, tell)
        return scene

    def assert_bound(self, scene, is_bound):
        self.assertEqual((scene.look(), scene.is_bound()), ("", is_bound))

    def test_weights_of_which_only_the_look_itself_tells_are_seen(self):
        obj = solved()
        scene = self.followed(obj)
        self.assert_bound(scene, True)
        obj.vertex_groups["Feet"].add(BOTTOM[:1], 0.5, "REPLACE")
        obj.data.update_tag()
        self.assert_bound(scene, False)
        self.assert_bound(scene, False)  # until it is bound again

    def test_two_writes_in_a_row_are_nobody_elses_change(self):
        obj = solved()
        scene = self.followed(obj)
        bpy.context.view_layer.update()
        self.assert_bound(scene, True)
        for _ in range(2):
            scene.update(scene.matrices(), 1, None)
        bpy.context.view_layer.update()
        self.assertFalse(scene._is_suspect)

    def test_without_a_window_nobody_is_painting(self):
        self.assertIs(module("scene.versions").is_painting(), False)

    def test_a_pull_takes_the_weights_as_they_are_when_it_begins(self):
        grab_region, api_pull = module("pull.region"), module("pull.hold")
        obj = posable()
        grab = grab_region.PulledPatch(np.array(MIDDLE, dtype=np.int32))
        depsgraph = bpy.context.evaluated_depsgraph_get()
        for weight in (1.0, 0.25):
            obj.vertex_groups["Feet"].add(BOTTOM, weight, "REPLACE")
            feet = api_pull.begin_pull(obj, depsgraph, [grab]).inputs.specs[0]
            self.assertEqual(feet.vertices.tolist(), BOTTOM)
            self.assert_close(feet.weights, np.full(len(BOTTOM), weight))


class SoftEdgeTest(SceneTest):
    def weights(self, obj, group="Head"):
        return module("scene.meshes").read_weights(obj, [group])[group]

    def test_weights_fade_along_the_surface_and_are_one_where_they_were(self):
        obj = posable()
        self.api.soften_group(obj, "Head", 1.0)
        weights, height = self.weights(obj), rest_positions(obj)[:, 2]
        share = np.clip(1.0 - (4.0 - height), 0.0, 1.0)
        self.assert_close(weights, share * share * (3.0 - 2.0 * share), 1e-3)
        self.assertEqual(np.flatnonzero(weights == 1.0).tolist(), TOP)

    def test_the_radius_is_of_the_world_and_of_the_rest_shape(self):
        obj = solved(matrix=Matrix.Diagonal((1.0, 1.0, 0.5, 1.0)))
        self.api.soften_group(obj, "Head", 1.0)
        self.assertEqual(float(np.ptp(rest_positions(obj)[self.weights(obj) > 0.0, 2])), 1.75)

    def test_softened_again_only_the_hard_vertices_and_the_radius_count(self):
        obj = posable()
        self.api.soften_group(obj, "Head", 0.7)
        once = self.weights(obj)
        obj.vertex_groups["Head"].add(BOTTOM, 0.4, "REPLACE")
        for radius in (2.0, 0.7):
            self.api.soften_group(obj, "Head", radius)
        self.assert_close(self.weights(obj), once, 0.0)
        self.api.soften_group(obj, "Head", 0.0)
        self.assertEqual(np.flatnonzero(self.weights(obj)).tolist(), TOP)

    def test_misuse_is_refused(self):
        obj = posable()
        soften = self.api.soften_group
        self.assert_error(ValueError, "radius = -1.0, must be 0 or more", soften, obj, "Head", -1.0)
        obj.vertex_groups["Head"].add(TOP, 0.9, "REPLACE")
        message = "Vertex group 'Head' of 'Tube' has no vertex of weight 1: paint some first"
        self.assert_error(ValueError, message, soften, obj, "Head", 1.0)


class GroupButtonTest(SceneTest):
    def setUp(self):
        super().setUp()
        self.obj = posable()
        bpy.context.view_layer.objects.active = self.obj

    def selected(self):
        return module("scene.meshes").selected_vertices(self.obj).tolist()

    def test_what_is_chosen_in_a_list_is_the_active_group(self):
        self.api.add_stiffness(self.obj, MIDDLE)
        self.api.add_pin(self.obj, MIDDLE, name="Waist")
        for kind, index, name in (
            ("control", 0, "Feet"),
            ("control", 2, "Waist"),
            ("control", 1, "Head"),
            ("stiffness", 0, "Stiff"),
            ("control", 7, "Stiff"),  # no entry
        ):
            setattr(self.obj.arap, f"active_{kind}_index", index)
            self.assertEqual(self.obj.vertex_groups.active.name, name)

    def test_paint_goes_to_weight_paint_and_back(self):
        empty = self.obj.arap.handles[0].target
        bpy.context.view_layer.objects.active = empty  # the panel stays on the mesh that it moves
        for group, mode in (("Feet", "WEIGHT_PAINT"), ("Head", "WEIGHT_PAINT"), ("Head", "OBJECT")):
            self.assertEqual(bpy.ops.arap.group_paint(vertex_group=group), {"FINISHED"})
            self.assertEqual((self.obj.mode, self.obj.vertex_groups.active.name), (mode, group))

    def test_select_selects_what_has_weight_and_nothing_else(self):
        self.obj.vertex_groups["Head"].add(BOTTOM, 0.0, "REPLACE")
        self.obj.data.vertices[TOP[0]].hide = True
        self.assertEqual(bpy.ops.arap.group_select(vertex_group="Head"), {"FINISHED"})
        self.assertEqual(self.obj.mode, "EDIT")
        self.assertEqual(self.selected(), TOP[1:])
        self.assertEqual(self.obj.data.total_edge_sel, len(TOP) - 2)
        bpy.ops.object.mode_set(mode="OBJECT")

    def test_select_leaves_edit_mode_once(self):
        """Entering it takes long on a large mesh."""
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.context.tool_settings.mesh_select_mode = (False, False, True)
        modes, mode_set = [], bpy.ops.object.mode_set

        def counted(*, mode: str):
            modes.append(mode)
            return mode_set(mode=mode)

        def select(group: str):
            ops = SimpleNamespace(object=SimpleNamespace(mode_set=counted))
            with mock.patch.object(bpy, "ops", ops):
                return select_group(vertex_group=group)

        select_group = bpy.ops.arap.group_select
        self.assertEqual(select("Head"), {"FINISHED"})
        self.assertEqual(modes, ["OBJECT", "EDIT"])
        self.assertEqual(self.selected(), TOP)
        self.assertEqual(tuple(bpy.context.tool_settings.mesh_select_mode), (True, False, False), "vertices are seen")
        bpy.ops.object.mode_set(mode="OBJECT")
        modes.clear()
        self.assertEqual(select("Head"), {"FINISHED"})
        self.assertEqual(modes, ["EDIT"])

    def test_select_of_a_group_without_weights_changes_nothing(self):
        self.obj.vertex_groups.new(name="None")
        for mode in ("OBJECT", "EDIT"):
            bpy.ops.object.mode_set(mode=mode)
            before = self.selected()
            with self.assertRaisesRegex(RuntimeError, "No vertex has weight in 'None': paint some, or assign vertices"):
                bpy.ops.arap.group_select(vertex_group="None")
            self.assertEqual((self.obj.mode, self.selected()), (mode, before))
        bpy.ops.object.mode_set(mode="OBJECT")

    def test_select_takes_no_other_mesh_along(self):
        other = mesh_object("Other")
        for obj in (other, self.obj):
            obj.select_set(True)
        bpy.context.view_layer.objects.active = self.obj
        bpy.ops.object.mode_set(mode="EDIT")
        self.assertEqual(other.mode, "EDIT", "of both, as Blender does")
        self.assertEqual(bpy.ops.arap.group_select(vertex_group="Head"), {"FINISHED"})
        self.assertEqual((self.obj.mode, other.mode), ("EDIT", "OBJECT"))
        self.assertEqual(self.selected(), TOP)
        bpy.ops.object.mode_set(mode="OBJECT")

    def test_soften_without_a_radius_takes_a_twentieth_of_the_size(self):
        def n_faded():
            return len(np.flatnonzero(module("scene.meshes").read_weights(self.obj, ["Head"])["Head"]))

        self.obj.arap.chosen_control_index = self.obj.arap.controls.find("Head")
        self.assertEqual(bpy.ops.arap.group_soften(), {"FINISHED"})
        self.assertEqual(n_faded(), len(TOP))  # the rings are further apart
        bpy.ops.object.mode_set(mode="EDIT")
        self.assertEqual(bpy.ops.arap.group_soften(vertex_group="Head", radius=1.0), {"FINISHED"})
        self.assertEqual(self.obj.mode, "EDIT")
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assertEqual(n_faded(), 4 * len(TOP))

    def test_without_a_group_the_buttons_are_grey(self):
        why = module("setup.group_operators").why_no_group
        self.assertEqual(why(bpy.context), "")
        self.obj.vertex_groups.clear()
        self.assertEqual(why(bpy.context), "There is no vertex group yet: add a pin, a handle or stiffness first")
