# SPDX-License-Identifier: GPL-3.0-or-later
"""Cages: a closed mesh around the mesh moves all of it."""

import base64
from unittest import mock

import bmesh
import numpy as np
from looks import key_positions, rest_positions, shown_positions
from mathutils import Matrix
from support import SceneTest, bpy, linked_back, module, opened_again
from tubes import BOTTOM, PLACED, TOP, animated, copied, mesh_object, move, posable

TURNED = Matrix.Translation((1.0, 2.0, 3.0)) @ Matrix.Rotation(0.6, 4, "X")


def box(obj, size=3.0, name="Box"):
    """A cube of quads around the tube, an object of its own."""
    bpy.ops.mesh.primitive_cube_add(size=size, location=obj.matrix_world.translation)
    cage = bpy.context.object
    cage.name = name
    cage.data.transform(Matrix.Diagonal((1.0, 1.0, 2.0, 1.0)) @ Matrix.Translation((0.0, 0.0, 1.0)))
    bpy.context.view_layer.update()
    return cage


def edit(cage, change):
    """Changes the vertices of a cage in Edit Mode, and stays in it."""
    bpy.context.view_layer.objects.active = cage
    bpy.ops.object.mode_set(mode="EDIT")
    edited = bmesh.from_edit_mesh(cage.data)
    for vertex in edited.verts:
        change(vertex)
    bmesh.update_edit_mesh(cage.data)
    bpy.context.view_layer.update()


def lift(vertex):
    if vertex.co.z > 2.0:
        vertex.co.x += 1.0


def moved(obj, *way):
    """Rest positions, moved."""
    return rest_positions(obj) + np.array(way)


class CageTest(SceneTest):
    def following(self, **options):
        obj = mesh_object()
        handle = self.api.make_cage(obj, **options)
        obj.arap.is_live = True
        bpy.context.view_layer.update()
        return obj, handle.target

    def light(self):
        light = bpy.data.objects.new("Light", bpy.data.lights.new("Light", "POINT"))
        self.scene.collection.objects.link(light)
        bpy.context.view_layer.update()
        return light

    def test_a_made_cage_is_around_the_mesh_and_leaves_it_in_place(self):
        for matrix in (None, PLACED):
            obj = mesh_object(matrix=matrix)
            handle = self.api.make_cage(obj)
            cage = handle.target
            self.assertEqual((handle.name, cage.name, cage.parent), ("Tube Cage", "Tube Cage", obj))
            self.assertEqual((cage.display_type, cage.hide_render), ("WIRE", True))
            self.assertEqual(list(cage.users_collection), list(obj.users_collection))
            corners = np.array([v.co[:] for v in cage.data.vertices])
            rest = rest_positions(obj)
            self.assertTrue((corners.min(axis=0) < rest.min(axis=0)).all())
            self.assertTrue((corners.max(axis=0) > rest.max(axis=0)).all())
            self.api.solve(obj)
            self.assert_close(key_positions(obj), rest, 1e-6)
            self.assertLess(len(corners), 300)
            self.api.remove_handle(obj, 0)
            self.assertEqual(list(bpy.data.objects), [obj])
            bpy.data.objects.remove(obj)

    def test_nothing_is_made_if_that_is_cancelled_or_the_mesh_goes(self):
        obj = mesh_object()
        job = module("cages.operators").FollowedCageJob(obj, 3)
        job.cancel()
        self.assertEqual((list(bpy.data.objects), len(obj.arap.handles)), ([obj], 0))
        job = module("cages.operators").FollowedCageJob(obj, 3)
        bpy.data.objects.remove(obj)
        message = "'Tube' is gone: its cage was not made"
        self.assert_error(RuntimeError, message, module("core.job").run_job, job)
        self.assertEqual(list(bpy.data.meshes), [bpy.data.meshes["Tube"]])

    def test_the_mesh_follows_what_is_edited_in_edit_mode(self):
        obj, cage = self.following()
        edit(cage, lift)
        self.assertEqual((obj.arap.is_live, obj.arap.live_problem), (True, ""))
        self.assert_close(shown_positions(obj)[TOP], moved(obj, 1.0, 0.0, 0.0)[TOP], 0.1)
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assert_close(shown_positions(obj)[TOP], moved(obj, 1.0, 0.0, 0.0)[TOP], 0.1)

    def test_shape_keys_and_modifiers_of_the_cage_move_the_mesh(self):
        obj, cage = self.following()
        cage.shape_key_add(name="Basis")
        key = cage.shape_key_add(name="Up")
        for point in key.data:
            point.co.z += 1.0
        key.value = 0.5
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(obj), moved(obj, 0.0, 0.0, 0.5), 1e-5)
        modifier = cage.modifiers.new("Move", "DISPLACE")
        modifier.direction, modifier.mid_level, modifier.strength = "X", 0.0, 0.25
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(obj), moved(obj, 0.25, 0.0, 0.5), 1e-5)

    def test_its_animation_is_baked_in_the_frames_of_its_keys(self):
        obj = animated()  # its handle rests
        cage = self.api.make_cage(obj).target
        cage.shape_key_add(name="Basis")
        key = cage.shape_key_add(name="Up")
        for point in key.data:
            point.co.z += 1.0
        for frame, value in ((3, 0.0), (13, 1.0)):
            key.value = value
            key.keyframe_insert("value", frame=frame)
        self.assertEqual(module("bake.frame_range").proposed_range(obj, self.scene), (3, 13))
        obj.arap.is_live = True
        self.scene.frame_set(8)
        self.assert_close(shown_positions(obj), moved(obj, 0.0, 0.0, 0.5), 1e-5)
        obj.arap.is_live = False
        for name, height in zip(self.api.bake_animation(obj, 3, 13, 10), (0.0, 1.0), strict=True):
            self.assert_close(key_positions(obj, name), moved(obj, 0.0, 0.0, height), 1e-5)

    def test_the_edge_of_half_a_mesh_stays_on_the_mirror_plane(self):
        obj = mesh_object()
        obj.data.transform(Matrix.Rotation(1.5707963, 4, "Y"))  # along x, from the plane
        obj.modifiers.new("Mirror", "MIRROR").use_clip = True
        cage = self.api.make_cage(obj).target
        cage.location = (0.5, 0.0, 1.0)
        cage.keyframe_insert("location", frame=1)
        expected = moved(obj, 0.5, 0.0, 1.0)
        expected[BOTTOM, 0] = 0.0
        self.assert_close(key_positions(obj, self.api.bake_animation(obj, 1, 1)[0]), expected, 1e-5)

    def test_handles_and_pins_rest_while_it_is_on(self):
        obj = posable()
        move(obj.arap.handles[0].target, (1.0, 0.0, 0.0))
        self.api.solve(obj)
        posed = key_positions(obj)
        handle = self.api.make_cage(obj)
        self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, 1e-6)
        move(obj.arap.handles[0].target, (0.0, 1.0, 0.0))
        obj.vertex_groups.remove(obj.vertex_groups["Feet"])
        self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, 1e-6)
        vertices, n_parts = module("scene.unheld").find(obj, bpy.context.evaluated_depsgraph_get())
        self.assertEqual((len(vertices), n_parts), (0, 0), "it moves all")
        handle.is_enabled = False
        with self.assertRaisesRegex(ValueError, "^Pin 'Feet' of 'Tube': there is no vertex group"):
            self.api.solve(obj)
        message = "Cage 'Tube Cage' moves 'Tube', so handles rest: switch it off first"
        handle.is_enabled = True
        self.assert_error(ValueError, message, self.api.store_pose, obj)

    def test_reset_handles_and_cancel_put_the_cage_back(self):
        obj, cage = self.following()
        at_rest = np.array([v.co[:] for v in cage.data.vertices])
        edit(cage, lift)
        cage.location.y = 2.0
        bpy.context.view_layer.update()
        self.assertEqual(self.api.reset_handles(obj), [])
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(obj), rest_positions(obj), 1e-5)
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assert_close([v.co[:] for v in cage.data.vertices], at_rest, 1e-6)
        edit(cage, lift)
        bpy.ops.object.mode_set(mode="OBJECT")
        cage.location.y = 2.0
        bpy.context.view_layer.update()
        module("pose.starts").end_following(obj, is_kept=False)
        self.assert_close([v.co[:] for v in cage.data.vertices], at_rest, 1e-6)
        self.assert_close(cage.location, (0.0, 0.0, 0.0), 0.0)

    def test_reset_handles_names_a_cage_that_something_else_holds(self):
        obj, cage = self.following()
        modifier = cage.modifiers.new("Move", "DISPLACE")
        modifier.direction, modifier.mid_level, modifier.strength = "X", 0.0, 0.25
        self.assertEqual(self.api.reset_handles(obj), ["Tube Cage"])

    def test_reset_handles_leaves_to_modifiers_and_shape_keys_what_they_do_at_rest(self):
        obj, cage = mesh_object(), box(mesh_object())
        modifier = cage.modifiers.new("Move", "DISPLACE")
        modifier.direction, modifier.mid_level, modifier.strength = "X", 0.0, 0.25
        for name, value in (("Basis", 0.0), ("Up", 0.5), ("Smile", 0.0)):
            cage.shape_key_add(name=name).value = value
        keys = cage.data.shape_keys.key_blocks
        for point in keys["Up"].data:
            point.co.z += 1.0
        bpy.context.view_layer.update()
        self.api.add_cage(obj, cage)
        at_rest = [key_positions(cage, name) for name in ("Basis", "Up")]
        for active in range(3):
            cage.active_shape_key_index = active
            edit(cage, lift)
            bpy.ops.object.mode_set(mode="OBJECT")
        keys["Up"].value, keys["Smile"].value = 0.9, 0.3
        offset = key_positions(cage, "Smile") - key_positions(cage, "Basis")
        for mode, held in (("OBJECT", []), ("OBJECT", []), ("EDIT", ["Box"])):  # in which the active key shows alone
            with self.subTest(mode):
                bpy.ops.object.mode_set(mode=mode)
                self.assertEqual(self.api.reset_handles(obj), held)
                bpy.ops.object.mode_set(mode="OBJECT")
                self.assert_close(key_positions(cage, "Basis"), at_rest[0], 0.0)
                self.assert_close(key_positions(cage, "Up"), at_rest[1], 0.0)
                self.assert_close(key_positions(cage, "Smile"), at_rest[0] + offset, 1e-6)
                self.assert_close([key.value for key in keys], (0.0, 0.5, 0.0), 1e-6)
                cage.active_shape_key_index = 1
                edit(cage, lift)

    def test_a_damaged_shape_of_a_cage_is_not_written(self):
        obj, cage = self.following()
        edit(cage, lift)
        bpy.ops.object.mode_set(mode="OBJECT")
        edited = [v.co[:] for v in cage.data.vertices]
        nan = base64.b64encode(np.full(3, np.nan, np.float32).tobytes()).decode()
        keys = '{"positions": "", "keys": {"Up": [%s]}}'
        for text in (
            "",
            "[]",
            '{"positions": "", "keys": {}}',
            f'{{"positions": "{nan}", "keys": {{}}}}',
            keys % '"", NaN',
        ):
            obj.arap.handles[0].cage_shape_text = text
            self.assertEqual(self.api.reset_handles(obj), ["Tube Cage"])
            self.assert_close([v.co[:] for v in cage.data.vertices], edited, 0.0)

    def test_cancel_puts_the_rest_and_new_shape_keys_of_the_cage_back(self):
        def add_again(obj, cage):
            edit(cage, lift)
            self.api.add_cage(obj, cage)

        def add_keys(_obj, cage):
            edit(cage, lift)
            bpy.ops.object.mode_set(mode="OBJECT")
            for name in ("Basis", "Up"):
                cage.shape_key_add(name=name).value = 1.0
            edit(cage, lift)

        for change in (add_again, add_keys):
            for mode in ("OBJECT", "EDIT"):
                with self.subTest(change.__name__, mode=mode):
                    self.setUp()
                    obj, cage = self.following()
                    change(obj, cage)
                    bpy.ops.object.mode_set(mode=mode)
                    self.assertEqual(module("pose.starts").end_following(obj, is_kept=False), [])
                    bpy.ops.object.mode_set(mode="OBJECT")
                    obj.arap.is_live = True
                    bpy.context.view_layer.update()
                    self.assert_close(shown_positions(obj), rest_positions(obj), 1e-6)

    def test_cancel_names_a_cage_that_cannot_go_back_and_leaves_it(self):
        obj, cage = self.following()
        other = self.api.add_cage(obj, box(obj))
        obj.arap.is_live = False
        obj.arap.is_live = True
        edit(cage, lift)
        edited = bmesh.from_edit_mesh(cage.data)
        bmesh.ops.subdivide_edges(edited, edges=edited.edges, cuts=1, use_grid_fill=True)
        bmesh.update_edit_mesh(cage.data)
        bpy.ops.object.mode_set(mode="OBJECT")
        rest = self.api.add_cage(obj, cage).cage_text
        other.target = box(obj, 4.0, "Larger")
        places = [v.co[:] for v in other.target.data.vertices]
        operator = mock.Mock(is_kept=False)
        module("pose.operators").ARAP_OT_follow_end.act(operator, bpy.context, obj)
        text = "Cage 'Tube Cage' cannot go back, as it has other vertices or shape keys now: press Add Cage again"
        operator.report.assert_called_once_with({"WARNING"}, text)
        self.assertEqual(obj.arap.handles[0].cage_text, rest)
        self.assert_close([v.co[:] for v in other.target.data.vertices], places, 0.0)

    def test_apply_pose_as_rest_makes_the_cage_rest_where_it_is(self):
        obj, cage = self.following()
        edit(cage, lift)
        bpy.ops.object.mode_set(mode="OBJECT")
        posed = shown_positions(obj)
        obj.arap.is_live = False
        self.api.apply_pose_as_rest(obj)
        self.assert_close(rest_positions(obj), posed, 1e-6)
        self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, 1e-6)

    def test_what_is_saved_is_there_after_opening(self):
        obj, cage = self.following(coordinates="harmonic")
        obj.arap.is_live = False
        edit(cage, lift)
        bpy.ops.object.mode_set(mode="OBJECT")
        self.api.solve(obj)
        posed = key_positions(obj)
        obj = opened_again()
        self.api.solve(obj)
        self.assertEqual(obj.arap.handles[0].coordinates, "harmonic")
        self.assert_close(key_positions(obj), posed, 1e-6)
        numbers = {i.identifier: i.value for i in obj.arap.handles[0].bl_rna.properties["coordinates"].enum_items}
        self.assertEqual(numbers, {"mean_value": 0, "harmonic": 1, "green": 2}, "files have the numbers")

    def test_a_copy_of_the_mesh_gets_a_cage_of_its_own(self):
        obj, cage = self.following()
        cage.shape_key_add(name="Basis").keyframe_insert("value", frame=1)
        twin = obj.copy()
        twin.data = obj.data.copy()
        self.scene.collection.objects.link(twin)
        twin.location.x = 5.0
        bpy.context.view_layer.update()
        self.assert_error(
            ValueError,
            "Cage 'Tube Cage' of 'Tube.001': its cage belongs to 'Tube', of which this is a copy; press Copy Handles",
            self.api.solve,
            twin,
        )
        self.api.copy_handles(twin)
        own = twin.arap.handles[0].target
        self.assertEqual((own.parent, own.data == cage.data), (twin, False))
        actions = {key.animation_data.action for key in (cage.data.shape_keys, own.data.shape_keys)}
        self.assertEqual(len(actions - {None}), 2)
        self.api.solve(twin)
        self.assert_close(key_positions(twin), rest_positions(twin), 1e-6)

    def test_another_cage_switches_the_former_off_and_add_cage_again_reads_its_shape_again(self):
        obj = mesh_object()
        self.api.make_cage(obj)
        cage = box(obj)
        handle = self.api.add_cage(obj, cage, "green")
        self.assertEqual([h.is_enabled for h in obj.arap.handles], [False, True])
        cage.location.z += 0.1
        bpy.context.view_layer.update()
        again = self.api.add_cage(obj, cage)
        self.assertEqual((len(obj.arap.handles), again, again.coordinates), (2, handle, "green"))
        self.api.solve(obj)
        self.assert_close(key_positions(obj), rest_positions(obj), 1e-6)

    def test_a_copy_of_the_mesh_shares_the_cage_if_that_is_added_to_it(self):
        obj, cage = self.following()
        twin = copied(obj)
        self.api.add_cage(twin, cage)
        twin.arap.is_live = True
        self.assertEqual([h.name for h in twin.arap.handles], ["Tube Cage"])
        cage.location.x += 1.0
        bpy.context.view_layer.update()
        for body in (obj, twin):
            self.assert_close(shown_positions(body), moved(body, 1.0, 0.0, 0.0), 1e-5)
        self.api.remove_handle(twin, 0)
        self.assertEqual(obj.arap.handles[0].target, cage)

    def test_only_the_cage_that_was_ticked_last_is_on(self):
        obj, cage = self.following()
        other = self.api.add_cage(obj, box(obj))
        obj.arap.handles[0].is_enabled = True
        self.assertFalse(other.is_enabled)
        cage.location.x += 1.0
        bpy.context.view_layer.update()
        self.assertEqual((obj.arap.is_live, obj.arap.live_problem), (True, ""))
        self.assert_close(shown_positions(obj), moved(obj, 1.0, 0.0, 0.0), 1e-5)

    def test_the_panel_stays_with_the_mesh_when_a_cage_of_two_is_chosen(self):
        first, second = mesh_object("First"), mesh_object("Second")
        cage = box(first)
        find = module("ui.checks").find_posed_object
        for obj in (first, second):
            self.api.add_cage(obj, cage)
        for obj in (second, first):
            bpy.context.view_layer.objects.active = obj
            self.assertEqual(find(bpy.context), obj)
            obj.arap.shown_row = 0
            self.assertEqual((bpy.context.object, find(bpy.context)), (cage, obj))
            module("scene.remembered").clear()  # an undo
            self.assertEqual(find(bpy.context), obj)

    def test_only_closed_meshes_can_be_chosen_and_follow_waits_for_one(self):
        obj, cage = self.following()
        handle = obj.arap.handles[0]
        wires = bpy.data.objects.new("Wires", bpy.data.meshes.new("Wires"))
        may_be = module("props.handles")._may_be_target
        self.assertEqual([may_be(handle, other) for other in (obj, self.light(), wires, cage)], [False] * 3 + [True])
        open_box = box(obj)
        edited = bmesh.new()
        edited.from_mesh(open_box.data)
        bmesh.ops.delete(edited, geom=edited.faces[:1], context="FACES_ONLY")
        edited.to_mesh(open_box.data)
        edited.free()
        handle.target = open_box
        bpy.context.view_layer.update()
        message = "^Paused: the cage is not closed: its edge from vertex [0-9]+ to [0-9]+ has 1 face; fill its holes"
        self.assertRegex(module("live.runs").run_of(obj).pause, message)
        self.assertIn("fill its holes", module("setup.handles").handle_problem(obj, 0))
        edited = bmesh.new()
        edited.from_mesh(open_box.data)
        bmesh.ops.holes_fill(edited, edges=edited.edges)
        edited.to_mesh(open_box.data)
        edited.free()
        bpy.context.view_layer.update()
        self.assertIn("at rest is not known; press Add Cage again", module("live.runs").run_of(obj).pause)
        handle.target = cage
        cage.location.x += 1.0
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(obj), moved(obj, 1.0, 0.0, 0.0), 1e-5)

    def test_follow_waits_while_a_modifier_makes_other_vertices(self):
        for mode in ("OBJECT", "EDIT"):
            with self.subTest(mode):
                self.setUp()
                obj, cage = self.following()
                n = len(cage.data.vertices)
                edit(cage, lambda vertex: None)
                bpy.ops.object.mode_set(mode=mode)
                modifier = cage.modifiers.new("Subdivision", "SUBSURF")
                bpy.context.view_layer.update()
                pause = module("live.runs").run_of(obj).pause
                self.assertRegex(pause, f"^Paused: 'Tube Cage' has {n} vertices, but [0-9]+ with its modifiers; switch")
                with self.assertRaisesRegex(ValueError, "^Cage 'Tube Cage' of 'Tube': 'Tube Cage' has .* but .* with"):
                    self.api.solve(obj)
                modifier.show_viewport = False
                cage.location.x += 1.0
                bpy.context.view_layer.update()
                self.assertEqual((obj.arap.is_live, obj.arap.live_problem), (True, ""))
                self.assert_close(shown_positions(obj), moved(obj, 1.0, 0.0, 0.0), 1e-5)

    def test_another_object_is_chosen_in_the_panel(self):
        obj, _ = self.following()
        cage = box(obj)
        obj.arap.handles[0].target = cage
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(obj), rest_positions(obj), 1e-6)
        cage.location.x += 1.0
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(obj), moved(obj, 1.0, 0.0, 0.0), 1e-5)

    def test_follow_waits_while_the_cage_has_another_number_of_vertices(self):
        obj, cage = self.following()
        edit(cage, lift)
        before = shown_positions(obj)
        edited = bmesh.from_edit_mesh(cage.data)
        edited.verts.new((0.0, 0.0, 9.0))
        bmesh.update_edit_mesh(cage.data)
        bpy.context.view_layer.update()
        n = len(cage.data.vertices)
        lack = f"'Tube Cage' has {n + 1} vertices now, but had {n}; undo that, or press Add Cage again"
        self.assertEqual((obj.arap.is_live, module("live.runs").run_of(obj).pause), (True, f"Paused: {lack}"))
        edited = bmesh.from_edit_mesh(cage.data)
        edited.verts.ensure_lookup_table()
        edited.verts.remove(edited.verts[-1])
        for vertex in edited.verts:
            vertex.co.y += 0.5
        bmesh.update_edit_mesh(cage.data)
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(obj), before + np.array([0.0, 0.5, 0.0]), 1e-5)

    def test_add_cage_in_edit_mode_takes_a_refined_cage(self):
        obj, cage = self.following()
        edit(cage, lift)
        shown = shown_positions(obj)
        edited = bmesh.from_edit_mesh(cage.data)
        bmesh.ops.subdivide_edges(edited, edges=edited.edges, cuts=1, use_grid_fill=True)
        bmesh.update_edit_mesh(cage.data)
        bpy.context.view_layer.update()
        self.assertIn("vertices now, but had", module("live.runs").run_of(obj).pause)
        cage.select_set(True)
        bpy.ops.arap.cage_add()
        bpy.context.view_layer.update()
        self.assertEqual((cage.mode, obj.arap.is_live), ("EDIT", True))
        self.assert_close(shown_positions(obj), shown, 1e-5)
        for vertex in bmesh.from_edit_mesh(cage.data).verts:
            vertex.co.y += 1.0
        bmesh.update_edit_mesh(cage.data)
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(obj), shown + np.array([0.0, 1.0, 0.0]), 1e-5)

    def test_a_pose_for_another_number_of_vertices_is_refused_until_add_cage_is_pressed_again(self):
        obj, cage = self.following()
        edit(cage, lift)
        bpy.ops.object.mode_set(mode="OBJECT")
        self.api.add_cage(obj, cage)
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.mode_set(mode="EDIT")
        bmesh.from_edit_mesh(obj.data).verts.new((0.0, 0.0, 2.0))
        bmesh.update_edit_mesh(obj.data)
        bpy.ops.object.mode_set(mode="OBJECT")
        n, posed = len(obj.data.vertices), key_positions(obj)
        message = (
            f"Cage 'Tube Cage': 'Tube' has {n} vertices now, but had {n - 1} when the cage was added to its pose; "
            "press Add Cage again"
        )
        self.assert_error(ValueError, message, self.api.solve, obj)
        self.assert_close(key_positions(obj), posed, 0.0)
        self.api.add_cage(obj, cage)
        self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, 1e-6)

    def test_what_cannot_be_is_refused_and_nothing_changes(self):
        obj = mesh_object()
        add = self.api.add_cage
        refused = "'Tube' cannot take the cage: "
        self.assert_error(ValueError, refused + "'Tube' is the mesh itself; choose another object", add, obj, obj)
        message = refused + "'Light' is not a mesh; choose a closed mesh around 'Tube'"
        self.assert_error(ValueError, message, add, obj, self.light())
        small = box(obj, 0.1, "Small")
        small.location.z = 1.0
        bpy.context.view_layer.update()
        message = refused + "'Small' is inside of 'Tube'; choose a closed mesh around it"
        self.assert_error(ValueError, message, add, obj, small)
        elsewhere = bpy.data.objects.new("Elsewhere", small.data)
        bpy.data.scenes.new("Other").collection.objects.link(elsewhere)
        message = refused + "'Elsewhere' is not in the scene; choose another object or remove the handle"
        self.assert_error(ValueError, message, add, obj, elsewhere)
        self.assertEqual(len(obj.arap.handles), 0)

    def test_a_mesh_that_cannot_be_a_cage_is_refused_and_the_present_one_stays_on(self):
        obj, _ = self.following()
        faceless, fine, open_box, with_ngon = (box(obj, name=name) for name in ("Faceless", "Fine", "Open", "Ngon"))
        fine.modifiers.new("Subdivision", "SUBSURF")
        for cage, change in (
            (faceless, lambda mesh: bmesh.ops.delete(mesh, geom=mesh.faces[:], context="FACES_ONLY")),
            (open_box, lambda mesh: bmesh.ops.delete(mesh, geom=mesh.faces[:1], context="FACES_ONLY")),
            (with_ngon, lambda mesh: bmesh.ops.bevel(mesh, geom=mesh.verts[:1], offset=0.1, affect="VERTICES")),
        ):
            edited = bmesh.new()
            edited.from_mesh(cage.data)
            change(edited)
            edited.to_mesh(cage.data)
            edited.free()
        bpy.context.view_layer.update()
        for cage, reason in (
            (faceless, "'Faceless' has no faces; choose a closed mesh around 'Tube'$"),
            (
                fine,
                "'Fine' has 8 vertices, but 26 with its modifiers; switch off the modifier that does it, or apply ",
            ),
            (open_box, "the cage is not closed: its edge from vertex [0-9]+ to [0-9]+ has 1 face; fill its holes"),
            (with_ngon, "face [0-9]+ of the cage has 5 corners, must have 3 or 4; cut it into triangles or quads$"),
        ):
            with self.assertRaisesRegex(ValueError, f"^'Tube' cannot take the cage: {reason}"):
                self.api.add_cage(obj, cage)
        self.assertEqual([handle.is_enabled for handle in obj.arap.handles], [True])
        self.assertEqual((obj.arap.is_live, obj.arap.live_problem), (True, ""))

    def test_a_cage_that_cannot_move_the_mesh_says_why(self):
        obj = mesh_object()
        cage = box(obj)
        handle = self.api.add_cage(obj, cage, "harmonic")
        cage.location.x += 1.3
        bpy.context.view_layer.update()
        self.api.add_cage(obj, cage)
        with self.assertRaisesRegex(
            ValueError, r"^Cage 'Box' cannot move the mesh: [0-9]+ of 136 points are not inside of the cage \("
        ):
            self.api.solve(obj)
        handle.coordinates = "mean_value"
        self.api.solve(obj)
        for text in ("!", "AAAA", base64.b64encode(np.full(24, np.nan).tobytes()).decode()):
            handle.cage_text = text
            message = "Cage 'Box' of 'Tube': the shape of 'Box' at rest is not known; press Add Cage again"
            self.assert_error(ValueError, message, self.api.solve, obj)
        handle.cage_text = base64.b64encode(np.full(24, 1e300).tobytes()).decode()
        with self.assertRaisesRegex(ValueError, "^Cage 'Box' cannot move the mesh: "):
            self.api.solve(obj)
        target, handle.target = cage, self.light()
        message = "Cage 'Box' of 'Tube': 'Light' is not a mesh; choose a closed mesh around 'Tube'"
        self.assert_error(ValueError, message, self.api.solve, obj)
        handle.target = target
        self.api.solve(obj)
        cage.name = "Renamed"
        self.api.solve(obj)
        edit(cage, lambda vertex: None)
        edited = bmesh.from_edit_mesh(cage.data)
        edited.faces.ensure_lookup_table()
        edited.faces.remove(edited.faces[0])
        bmesh.update_edit_mesh(cage.data)
        bpy.ops.object.mode_set(mode="OBJECT")
        with self.assertRaisesRegex(ValueError, "^Cage 'Box' cannot move the mesh: the cage is not closed: its edge"):
            self.api.solve(obj)
        self.scene.collection.objects.unlink(cage)
        bpy.data.scenes.new("Other").collection.objects.link(cage)
        message = "Cage 'Box' of 'Tube': 'Renamed' is not in the scene; choose another object or remove the handle"
        self.assert_error(ValueError, message, self.api.solve, obj)
        bpy.data.objects.remove(cage)
        message = "Cage 'Box' of 'Tube': it has no object; choose one or remove the handle"
        self.assert_error(ValueError, message, self.api.solve, obj)

    def test_a_linked_cage_and_one_for_two_meshes(self):
        box(self.following()[0])
        [cage] = linked_back(bpy.data.objects["Box"], "Box")
        bpy.context.scene.collection.objects.link(cage)
        for name in ("Tube", "Twin"):
            obj = mesh_object(name)
            self.api.add_cage(obj, cage)
            obj.arap.is_live = True
            self.assertEqual(self.api.reset_handles(obj), [])
        cage.location.x += 1.0
        bpy.context.view_layer.update()
        for name in ("Tube", "Twin"):
            obj = bpy.data.objects[name]
            self.assertEqual(obj.arap.live_problem, "")
            self.assert_close(shown_positions(obj), moved(obj, 1.0, 0.0, 0.0), 1e-5)

    def test_copies_of_mesh_and_cage_belong_together(self):
        obj, _ = self.following()
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.duplicate()
        twin, own = bpy.data.objects["Tube.001"], bpy.data.objects["Tube Cage.001"]
        self.assertEqual((twin.arap.handles[0].target, own.parent), (own, twin))
        own.location.x += 1.0
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(twin), moved(twin, 1.0, 0.0, 0.0), 1e-5)
        self.assert_close(shown_positions(obj), rest_positions(obj), 1e-5)

    def test_the_operators_take_what_is_selected_and_the_panel_stays_with_the_mesh(self):
        obj = mesh_object()
        find = module("ui.checks").find_posed_object
        bpy.context.view_layer.objects.active = obj
        bpy.ops.arap.cage_make(cells=3)
        made = obj.arap.handles[0].target
        self.assertEqual((bpy.context.object, find(bpy.context), obj.arap.is_live), (made, obj, True))
        self.assertFalse(bpy.ops.arap.pull_tool.poll())
        message = "A cage moves the mesh, and its poses are its own shape keys: add these to the cage, or untick it"
        self.assertIn(message, module("poses.operators").why_not_storable(bpy.context))
        bpy.ops.object.select_all(action="DESELECT")
        bpy.context.view_layer.objects.active = obj
        self.assertFalse(bpy.ops.arap.cage_add.poll())
        cage = box(obj)
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
        bpy.ops.arap.cage_add()
        self.assertEqual([(h.target, h.is_enabled) for h in obj.arap.handles], [(made, False), (cage, True)])
        self.assertEqual((bpy.context.object, find(bpy.context), obj.arap.is_live), (cage, obj, True))
        bpy.ops.object.mode_set(mode="EDIT")
        with self.assertRaisesRegex(RuntimeError, "'Box' is in another mode: go back to Object Mode first"):
            obj.arap.handles[1].has_made_target = True
            bpy.ops.arap.handle_remove()

    def test_it_follows_the_object_of_the_cage_exactly(self):
        for coordinates in ("mean_value", "harmonic", "green"):
            with self.subTest(coordinates):
                obj, cage = self.following(coordinates=coordinates)
                cage.matrix_local = TURNED
                bpy.context.view_layer.update()
                turned = np.array(TURNED)
                expected = rest_positions(obj) @ turned[:3, :3].T + turned[:3, 3]
                self.assert_close(shown_positions(obj), expected, 1e-4)
                self.setUp()
