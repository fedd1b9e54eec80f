# SPDX-License-Identifier: GPL-3.0-or-later
"""Make Stand-in: a tube in three pieces is posed as one, through a stand-in."""

import numpy as np
from looks import group_of, in_world, key_names, rest_positions, shown_positions
from support import SceneTest, bpy, linked_back, module
from tubes import PLACED, Matrix, mesh_object, move, tube_arrays

ENDS = ((-1.5, 1.0), (1.0, 3.0), (2.9, 5.5))
"""Of the pieces along z: the first two meet, the last two overlap."""


def piece(name, low, high, matrix=None):
    """A closed tube. ``matrix``: of its object; it is where it would be without."""
    positions, faces = tube_arrays()
    positions[:, 2] = low + positions[:, 2] * (high - low) / 4.0
    world = matrix or Matrix()
    inverse = np.array(world.inverted())
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata((positions @ inverse[:3, :3].T + inverse[:3, 3]).tolist(), [], faces)
    obj = bpy.data.objects.new(name, mesh)
    obj.matrix_world = world
    bpy.context.scene.collection.objects.link(obj)
    return obj


def pieces(matrix=None):
    made = [piece(name, *ends, matrix) for name, ends in zip(("Leg", "Belly", "Chest"), ENDS, strict=True)]
    bpy.context.view_layer.update()
    return made


def world_rest(obj):
    return in_world(obj, rest_positions(obj))


def world_shown(obj):
    return in_world(obj, shown_positions(obj))


class TogetherTest(SceneTest):
    def bent(self, stand_in):
        """Poses it with a pin and a handle at its ends."""
        z = world_rest(stand_in)[:, 2]
        self.api.add_pin(stand_in, np.flatnonzero(z < -1.2), name="Foot")
        handle = stand_in.arap.controls[self.api.add_handle(stand_in, np.flatnonzero(z > 5.2), name="Head")]
        move(handle.target, (1.5, 0.5, -0.8), (0.3, 1.0, 0.0))
        self.api.solve(stand_in)

    def assert_whole(self, made):
        """The ends of pieces that meet are together still, and of those that overlap, the one is in the other."""
        leg, belly, chest = ([world_rest(obj), world_shown(obj)] for obj in made)
        end, begin = leg[0][:, 2] > 0.99, belly[0][:, 2] < 1.01
        self.assert_close(leg[1][end], belly[1][begin], 1e-3)
        inside = np.linalg.norm(
            chest[1][chest[0][:, 2] < 2.95].mean(axis=0) - belly[1][belly[0][:, 2] > 2.9].mean(axis=0)
        )
        self.assertLess(inside, 0.12)
        self.assertGreater(np.abs(chest[1] - chest[0]).max(), 1.0)

    def test_the_pieces_stay_together_under_any_scale(self):
        for matrix in (None, PLACED, Matrix.Diagonal((-1.0, 1.0, 1.0, 1.0))):
            with self.subTest(matrix=matrix):
                made = pieces(matrix)
                stand_in = self.api.make_stand_in(made)
                self.bent(stand_in)
                self.assert_whole(made)
                self.assertEqual([key_names(obj) for obj in made], 3 * [["Basis", "ARAP"]])
                for obj in [*made, stand_in]:
                    bpy.data.objects.remove(obj)

    def test_the_stand_in_has_their_vertices_and_is_a_solid_that_hides_nothing(self):
        made = pieces()
        stand_in = self.api.make_stand_in(made)
        near = {tuple(place) for place in np.round(world_rest(stand_in), 4)}
        for obj in made:
            self.assertLessEqual({tuple(place) for place in np.round(world_rest(obj), 4)}, near)
        self.assertEqual((stand_in.arap.model, stand_in.display_type, stand_in.hide_render), ("solid", "BOUNDS", True))
        self.assertEqual([attachment.kind for attachment in stand_in.arap.attachments], 3 * ["bend"])
        self.bent(stand_in)
        rest, shown = world_rest(stand_in), world_shown(stand_in)
        for obj in made:
            nearest = [np.linalg.norm(rest - place, axis=1).argmin() for place in world_rest(obj)]
            self.assert_close(world_shown(obj), shown[nearest], 2e-5)
        self.assertEqual(module("core.sessions").stats(stand_in.session_uid).parts_at_rest, 0)

    def test_a_light_stand_in_of_a_heavy_mesh(self):
        made = pieces()
        light = self.api.make_stand_in(made, vertices=200)
        few = len(light.data.vertices)
        self.api.remove_stand_in(light)
        stand_in = self.api.make_stand_in(made[:1], vertices=100)
        self.assertLess(len(stand_in.data.vertices), 1000)
        self.api.remove_stand_in(stand_in)
        stand_in = self.api.make_stand_in(made)
        self.assertLess(few, len(stand_in.data.vertices) / 2)

    def test_groups_of_one_name_are_one_and_what_is_pinned_stays_pinned(self):
        made = pieces()
        for name in ("Foot", "Gone"):
            self.api.add_pin(made[0], range(8), name=name)
        made[0].vertex_groups.remove(made[0].vertex_groups["Gone"])
        for obj in made[1:]:
            obj.vertex_groups.new(name="Upper").add(range(len(obj.data.vertices)), 0.5, "REPLACE")
        stand_in = self.api.make_stand_in(made)
        self.assertEqual(stand_in.vertex_groups.keys(), ["Foot", "Upper"])
        self.assertEqual([pin.name for pin in stand_in.arap.pins], ["Foot"])
        z = world_rest(stand_in)[:, 2]
        foot, upper = group_of(stand_in, "Foot"), group_of(stand_in, "Upper")
        self.assertEqual(set(foot.values()), {1.0})
        self.assertLess(z[list(foot)].max(), -1.2)
        self.assertEqual(set(upper), set(np.flatnonzero(z >= 1.0 - 1e-6)))
        self.assert_close(list(upper.values()), 0.5, 1e-6)

    def test_removed_the_pieces_are_as_before(self):
        made = pieces()
        stand_in = self.api.make_stand_in(made)
        self.bent(stand_in)
        before = {obj.name for obj in bpy.data.objects}
        self.api.remove_stand_in(stand_in)
        self.assertEqual(before - {obj.name for obj in bpy.data.objects}, {"Stand-in", "Head"})
        self.assertEqual([key_names(obj) for obj in made], 3 * [[]])
        self.assertEqual([mesh.name for mesh in bpy.data.meshes], ["Belly", "Chest", "Leg"])
        self.assert_error(
            ValueError,
            "'Leg' is no stand-in: choose one that Make Stand-in has made",
            self.api.remove_stand_in,
            made[0],
        )

    def test_removed_its_children_stay_where_they_are(self):
        made = pieces()
        stand_in = self.api.make_stand_in(made)
        for obj in made:
            obj.parent = stand_in
            obj.matrix_parent_inverse = stand_in.matrix_world.inverted()
        move(stand_in, (5.0, 0.0, 1.0), (0.0, 0.0, 1.0))
        before = [world_shown(obj) for obj in made]
        self.api.remove_stand_in(stand_in)
        bpy.context.view_layer.update()
        for obj, places in zip(made, before, strict=True):
            self.assert_close(world_shown(obj), places, 1e-5)

    def test_removed_it_is_in_no_list_any_more(self):
        host = mesh_object("Body")
        stand_in = self.api.make_stand_in(pieces())
        self.api.attach(host, [stand_in])
        self.api.remove_stand_in(stand_in)
        self.assertEqual(len(host.arap.attachments), 0)

    def test_in_edit_mode_nothing_is_removed(self):
        made = pieces()
        stand_in = self.api.make_stand_in(made)
        bpy.context.view_layer.objects.active = made[1]
        bpy.ops.object.mode_set(mode="EDIT")
        message = "'Belly' is in Edit Mode: go back to Object Mode first"
        self.assert_error(ValueError, message, self.api.remove_stand_in, stand_in)
        self.assertEqual(len(stand_in.arap.attachments), 3)
        bpy.ops.object.mode_set(mode="OBJECT")

    def test_what_cannot_be_posed_together_is_told_and_nothing_has_changed(self):
        made = pieces()
        line = bpy.data.meshes.new("Line")
        line.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
        lines = [bpy.data.objects.new("Line", mesh) for mesh in (line, line.copy())]
        for obj in lines:
            self.scene.collection.objects.link(obj)
        bpy.context.view_layer.update()
        cases = (
            ([], "Select the meshes to pose together first"),
            (
                made[:1],
                "Select other meshes, too: 'Leg' alone has no more than 200,000 vertices and can be posed itself",
            ),
            (lines, "None of the meshes has a face: there is nothing to deform"),
        )
        for objects, message in cases:
            self.assert_error(ValueError, message, self.api.make_stand_in, objects)
        flat = [mesh_object(f"Flat{i}") for i in range(2)]
        for obj in flat:
            obj.data.vertices.foreach_set("co", np.zeros(3 * len(obj.data.vertices)))
        message = "The meshes have no size: move their vertices apart"
        self.assert_error(ValueError, message, self.api.make_stand_in, flat)
        flat[1].data.vertices[3].co.y = np.nan
        with self.assertRaisesRegex(ValueError, "^Vertex 3 of 'Flat1' is at no finite place"):
            self.api.make_stand_in(flat)
        self.assert_error(ValueError, "vertices = 0, must be >= 1", self.api.make_stand_in, made, 0)
        message = "With 1 vertices no face is left of these meshes: raise Vertices"
        self.assert_error(ValueError, message, self.api.make_stand_in, made, 1)
        self.api.make_stand_in(made)
        message = (
            "'Leg' cannot be attached to 'Stand-in.001': it is attached to 'Stand-in' already; detach it there first"
        )
        self.assert_error(ValueError, message, self.api.make_stand_in, made)
        self.assertEqual(len([obj for obj in bpy.data.objects if obj.arap.is_stand_in]), 1)

    def test_pieces_with_a_pose_of_their_own_are_told(self):
        made = pieces()
        for obj in made[:2]:
            self.api.add_pin(obj, range(8), name="Low")
            move(obj.arap.controls[self.api.add_handle(obj, range(128, 136), name="High")].target, (0.5, 0.0, 0.0))
            self.api.solve(obj)
        self.api.reset_pose(made[0])
        shown = [world_shown(obj) for obj in made]
        job = module("attach.stand_in").StandInJob(made)
        stand_in = module("core.job").run_job(job)
        self.assertEqual(
            job.warning,
            "The stand-in is at rest, and its pose is added to the poses of Belly: press Reset for each of them",
        )
        for obj, places in zip(made, shown, strict=True):
            self.assert_close(world_shown(obj), places)
        self.assertLess(np.abs(world_rest(stand_in)[:, 0]).max(), 0.51)
        self.api.reset_pose(made[1])
        self.bent(stand_in)
        self.assert_whole(made)

    def test_cancelled_nothing_has_changed(self):
        made = pieces()
        message = "The stand-in of 'Leg' was cancelled; nothing has changed"
        with self.assertRaises(self.api.Cancelled) as caught:
            module("core.job").run_job(SlowJob(made), lambda fraction: False)
        self.assertEqual(str(caught.exception), message)
        self.assertEqual(len(bpy.data.objects), 3)
        self.assertTrue(all(obj.data.shape_keys is None for obj in made))

    def test_a_mesh_that_is_gone_meanwhile_is_told(self):
        made = pieces()
        job = module("attach.stand_in").StandInJob(made)
        while job.step():
            pass
        bpy.data.objects.remove(made[1])
        self.assert_error(RuntimeError, "'Belly' is gone: the stand-in was not made", job.finish)


def SlowJob(made):  # noqa: N802 - stands for a class
    """A job whose steps each do one thing."""
    job = module("attach.stand_in").StandInJob(made)
    step = job.step
    job.step = lambda time_limit_s=0.0: step(1e-9)
    return job


class FollowersTest(SceneTest):
    """Meshes that go along with others."""

    def test_a_piece_keeps_what_goes_along_with_it(self):
        made, coat, button = pieces(), piece("Coat", 1.2, 2.8), piece("Button", 2.0, 2.2)
        self.api.attach(made[1], [coat], "bend")
        self.api.attach(coat, [button], "bend")
        job = module("attach.stand_in").StandInJob([coat, *made, button])
        stand_in = module("core.job").run_job(job)
        self.assertEqual([attachment.object for attachment in stand_in.arap.attachments], made)
        self.assertEqual(
            module("attach.stand_in_operators").ARAP_OT_stand_in_make.result_text(None, job, stand_in),
            f"'Stand-in' has {len(stand_in.data.vertices):,} vertices: pose it, or pull any of the meshes. "
            "Attached to their own hosts as before: Coat, Button",
        )
        z = world_rest(stand_in)[:, 2]
        self.api.add_pin(stand_in, np.flatnonzero(z < -1.2), name="Foot")
        move(
            stand_in.arap.controls[self.api.add_handle(stand_in, np.flatnonzero(z > 5.2), name="Head")].target,
            (1.5, 0.5, -0.8),
        )
        self.api.solve(stand_in)
        # All three are tubes around the same middle at rest.
        middles = [world_shown(obj).mean(axis=0) for obj in (made[1], coat, button)]
        self.assertGreater(np.abs(middles[0] - (0.0, 0.0, 2.0)).max(), 0.2)
        self.assert_close(middles[1:], [middles[0]] * 2, 0.1)
        self.api.remove_stand_in(stand_in)
        self.assertEqual([obj.arap.attached_to.host for obj in (coat, button)], [made[1], coat])

    def test_a_body_with_its_followers_is_one_mesh(self):
        host, coat = piece("Body", 0.0, 4.0), piece("Coat", 1.0, 3.0)
        bpy.context.view_layer.update()
        self.api.attach(host, [coat])
        message = "Select other meshes, too: 'Body' alone has no more than 200,000 vertices and can be posed itself"
        self.assert_error(ValueError, message, self.api.make_stand_in, [coat, host])


class OperatorTest(SceneTest):
    def select(self, *objects):
        for obj in bpy.context.view_layer.objects:
            obj.select_set(obj in objects)
        bpy.context.view_layer.objects.active = objects[0] if objects else None

    def test_the_selected_meshes_become_one_and_are_free_again(self):
        made = pieces()
        why = module("attach.stand_in_operators").why_not_together
        self.select()
        self.assertEqual(why(bpy.context), "Select the meshes to pose together first")
        self.select(*made)
        self.assertEqual(bpy.ops.arap.stand_in_make(vertices=1000), {"FINISHED"})
        stand_in = bpy.data.objects["Stand-in"]
        self.assertEqual((bpy.context.object, bpy.context.selected_objects), (stand_in, [stand_in]))
        self.select(made[2])
        self.assertEqual(bpy.ops.arap.host_select(), {"FINISHED"})
        self.assertEqual(bpy.context.object, stand_in)
        self.select(made[1])
        self.assertEqual(bpy.ops.arap.stand_in_remove(), {"FINISHED"})
        self.assertEqual(set(bpy.context.selected_objects), set(made))
        operators = module("attach.operators")
        self.assertEqual(operators.why_nothing_attached(bpy.context), "Nothing is attached to this mesh")
        self.assertEqual(operators.why_no_host_of_it(bpy.context), "This mesh is attached to nothing")
        bpy.ops.object.mode_set(mode="EDIT")
        self.assertEqual(why(bpy.context), "Go to Object Mode first (Tab)")
        bpy.ops.object.mode_set(mode="OBJECT")

    def test_a_deleted_stand_in_lets_its_meshes_go(self):
        made = pieces()
        self.api.make_stand_in(made)
        self.select(bpy.data.objects["Stand-in"])
        bpy.ops.object.delete()
        text = module("attach.problems").left_out_text
        self.assertEqual(
            text(made[0]),
            "It followed 'Stand-in', which was deleted: bring that back (Ctrl Z), or press Remove Stand-in",
        )
        self.assertEqual(module("attach.hosts").moving_mesh(made[0]), made[0])
        self.select(made[0])
        self.assertEqual(bpy.ops.arap.stand_in_remove(), {"FINISHED"})
        self.assertEqual([key_names(obj) for obj in made], 3 * [[]])
        empty = self.api.make_stand_in(made)
        for piece in made:
            self.api.detach(empty, piece)
        self.select(empty)
        self.assertEqual(bpy.ops.arap.stand_in_remove(), {"FINISHED"}, "nothing is attached to it any more")
        self.assertEqual(text(made[0]), "")
        host, coat = mesh_object("Body"), mesh_object("Coat")
        self.api.attach(host, [coat])
        self.select(host)
        bpy.ops.object.delete()
        self.assertEqual(
            text(coat),
            "It followed 'Body', which was deleted: bring that back (Ctrl Z), or attach it to another mesh",
        )

    def test_undo_and_redo(self):
        made = pieces()
        self.select(*made)
        bpy.ops.ed.undo_push(message="before")
        bpy.ops.arap.stand_in_make()
        bpy.ops.ed.undo_push(message="together")
        bpy.ops.ed.undo()
        self.assertEqual({obj.name for obj in bpy.data.objects}, {"Leg", "Belly", "Chest"})
        self.assertIsNone(bpy.data.objects["Leg"].arap.attached_to.host)
        bpy.ops.ed.redo()
        self.assertEqual(len(bpy.data.objects["Stand-in"].arap.attachments), 3)

    def test_linked_meshes_are_told_before(self):
        (linked,) = linked_back(pieces()[0], "Leg")
        self.scene = bpy.context.scene
        self.scene.collection.objects.link(linked)
        bpy.context.view_layer.update()
        self.select(mesh_object(), linked)
        self.assertEqual(
            module("attach.stand_in_operators").why_not_together(bpy.context),
            "'Leg' is linked from another file: make it local (Object > Relations > Make Local)",
        )

    def test_one_mesh_stays_itself(self):
        obj = mesh_object()
        self.select(obj)
        self.assertFalse(bpy.ops.arap.stand_in_make.poll())
