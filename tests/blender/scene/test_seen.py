# SPDX-License-Identifier: GPL-3.0-or-later
"""A pose that would not be seen is refused before anything is solved, by one look that leaves no trace."""

from unittest import mock

import bpy
import numpy as np
from looks import key_names, key_positions, rest_positions, shown_positions
from modifiers import add_nodes
from support import SceneTest, module
from tubes import BOTTOM, TOP, animate, mesh_object, own_key, posable

SEEN = "A pose of 'Tube' would not be seen: "
REMEDY = "switch it off in viewports and renders"


class SeenTest(SceneTest):
    def look(self, obj, rows=None, **options) -> str:
        return module("scene.seen.look").look(obj, bpy.context.evaluated_depsgraph_get(), rows, **options)

    def alembic_tube(self) -> bpy.types.Object:
        """A posable tube whose vertices come from an Alembic file."""
        path = str(self.new_folder() / "tube.abc")
        mesh_object()
        bpy.ops.wm.alembic_export(filepath=path, start=1, end=2, as_background_job=False)
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        obj = posable()
        bpy.ops.cachefile.open(filepath=path)
        modifier = obj.modifiers.new("Alembic", "MESH_SEQUENCE_CACHE")
        modifier.cache_file = bpy.data.cache_files[0]
        modifier.object_path = "/Tube/Tube"
        bpy.context.view_layer.update()
        return obj

    def assert_refused(self, obj, message: str) -> None:
        """By all that shows a pose, and nothing is written."""
        keys = key_names(obj)
        self.assert_error(ValueError, message, self.api.bake_animation, obj, 1, 2)
        self.assert_error(ValueError, message, self.api.solve, obj)
        self.assert_error(ValueError, message, self.api.begin_solve, obj)
        self.assertEqual(key_names(obj), keys)

    if bpy.app.alembic.supported:  # Debian builds Blender without

        def test_a_mesh_whose_vertices_come_from_an_alembic_file(self):
            obj = self.alembic_tube()
            message = f"{SEEN}modifier 'Alembic' takes the vertices from elsewhere; {REMEDY}"
            self.assert_refused(obj, message)
            self.assert_error(ValueError, message, self.api.prepare_session, obj)
            obj.modifiers["Alembic"].read_data = {"UV"}
            self.assertEqual(self.look(obj), "")

    def test_nodes_that_set_places(self):
        obj = posable()
        add_nodes(obj, takes_places=False, name="Through")
        self.assertEqual(self.look(obj), "")
        add_nodes(obj, takes_places=True)
        names = "one of the modifiers 'Through', 'Nodes' may take the vertices from elsewhere"
        self.assert_refused(obj, f"{SEEN}{names}; {REMEDY}")
        obj.modifiers["Nodes"].show_viewport = False
        self.assertEqual(self.look(obj), "")

    def test_modifiers_after_the_one_that_hides_the_pose(self):
        obj = posable()
        add_nodes(obj, takes_places=True)
        obj.modifiers.new("Smooth", "SUBSURF")
        self.assert_refused(obj, f"{SEEN}modifier 'Nodes' takes the vertices from elsewhere; {REMEDY}")

    def test_a_modifier_that_is_on_in_renders_alone_hides_a_bake(self):
        obj = posable()
        add_nodes(obj, takes_places=True).show_viewport = False
        message = f"{SEEN}modifier 'Nodes' takes the vertices from elsewhere; {REMEDY}"
        self.assert_error(ValueError, message, self.api.bake_animation, obj, 1, 2)
        self.assertFalse(obj.modifiers["Nodes"].show_viewport)
        obj.modifiers["Nodes"].show_render = False
        module("bake.keys").BakeJob(obj, 1, 2).cancel()

    def test_a_bake_under_a_mesh_cache(self):
        obj = posable()
        animate(obj)
        self.api.export_mesh_cache(obj, self.new_folder() / "tube.pc2", 1, 3, add_modifier=True)
        shows = "Modifier 'ARAP Cache' of 'Tube' shows a cache in place of the pose"
        message = f"{shows}: switch it off, in viewports and renders"
        self.assert_refused(obj, message)
        # Another export takes the place of this one.
        self.api.export_mesh_cache(obj, self.new_folder() / "tube.pc2", 1, 3, add_modifier=True)
        add_nodes(obj, takes_places=True)
        message = f"{SEEN}modifier 'Nodes' takes the vertices from elsewhere; {REMEDY}"
        path = self.new_folder() / "tube.pc2"
        self.assert_error(ValueError, message, self.api.export_mesh_cache, obj, path, 1, 3, add_modifier=True)
        self.api.export_mesh_cache(obj, path, 1, 3)  # the file is seen elsewhere

    def test_a_mesh_far_from_its_origin_keeps_its_shape_in_the_look(self):
        """A modifier that makes a new mesh of it, as Remesh, would work for hours on one that is torn apart."""
        obj = posable()
        far = (rest_positions(obj) + 1000.0).astype(np.float32)
        obj.data.attributes["position"].data.foreach_set("vector", far.ravel())
        add_nodes(obj, takes_places=False)
        shown = []
        versions = module("scene.versions")
        with mock.patch.object(versions, "write_positions", lambda _mesh, positions: shown.append(positions)):
            self.look(obj)
        displaced, back = shown
        self.assertTrue((back == far).all())
        self.assertLess(np.abs(displaced - far).max(), 0.1)
        self.assertEqual(self.look(obj), "")
        add_nodes(obj, takes_places=True)
        self.assertIn("would not be seen", self.look(obj))

    def test_another_key_shown_alone(self):
        obj = posable()
        own_key(obj, "Mine")
        obj.active_shape_key_index, obj.show_only_shape_key = 1, True
        message = "'Tube' shows another shape key alone: turn off Shape Key Lock (the pin icon)"
        self.assert_refused(obj, message)

    def test_keys_of_the_artist_do_not_hide_a_pose(self):
        obj = posable()
        own_key(obj, "Mine")
        own_key(obj, "On it").relative_key = obj.data.shape_keys.key_blocks["Mine"]
        add_nodes(obj, takes_places=False)
        self.assertEqual(self.look(obj), "")

    def test_only_the_vertices_that_handles_hold_count(self):
        obj = posable()
        animate(obj)
        path = self.new_folder() / "tube.pc2"
        self.api.export_mesh_cache(obj, path, 1, 3)
        modifier = obj.modifiers.new("Part", "MESH_CACHE")
        modifier.cache_format, modifier.filepath, modifier.vertex_group = "PC2", str(path), "Head"
        self.assertEqual(self.look(obj), "")
        self.assertEqual(self.look(obj, BOTTOM), "")
        self.assertTrue(self.look(obj, TOP))
        self.assert_refused(obj, f"{SEEN}modifier 'Part' takes the vertices from elsewhere; {REMEDY}")

    def test_a_simulation_is_left_alone(self):
        obj = posable()
        obj.modifiers.new("Cloth", "CLOTH")
        add_nodes(obj, takes_places=True)
        self.assertEqual(self.look(obj), "")

    def test_a_mesh_that_does_not_show_in_this_frame(self):
        obj = posable()
        build = obj.modifiers.new("Build", "BUILD")
        build.frame_start, build.frame_duration = 10.0, 10.0
        self.assertEqual(self.look(obj), "")

    def test_a_look_leaves_no_trace(self):
        for has_keys in (False, True):
            with self.subTest(has_keys=has_keys):
                bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
                obj = posable()
                if has_keys:
                    own_key(obj, "Mine", value=0.5)
                add_nodes(obj, takes_places=True)
                keys = obj.data.shape_keys.key_blocks if has_keys else ()
                before = [key_positions(obj, key.name) for key in keys]
                own = np.array([vertex.co[:] for vertex in obj.data.vertices])
                seen = shown_positions(obj)
                self.assertTrue(self.look(obj))
                np.testing.assert_array_equal([key_positions(obj, key.name) for key in keys], before)
                np.testing.assert_array_equal([vertex.co[:] for vertex in obj.data.vertices], own)
                np.testing.assert_array_equal(shown_positions(obj), seen)
                self.assertEqual(len(keys), 2 if has_keys else 0)

    def test_our_handler_does_not_hear_of_a_look(self):
        obj = posable()
        add_nodes(obj, takes_places=True)
        with mock.patch.object(module("scene.known"), "updates", return_value=[]) as heard:
            self.look(obj)
            heard.assert_not_called()
            obj.location.x = 1.0
            bpy.context.view_layer.update()
            heard.assert_called_once()

    def test_what_a_look_said_is_told_until_the_mesh_may_be_seen(self):
        look = module("scene.seen.look")
        obj = posable()
        modifier = add_nodes(obj, takes_places=True)
        self.assertEqual((look.is_noted(obj), look.noted(obj)), (False, ""))
        message = self.look(obj)
        self.assertEqual((look.is_noted(obj), look.noted(obj)), (True, message))
        bpy.context.view_layer.objects.active = obj
        self.assertEqual(module("tab.next_step").next_step(bpy.context).text, f"{message}.")
        modifier.node_group.nodes["Set Position"].inputs["Selection"].default_value = False
        bpy.context.view_layer.update()
        self.assertEqual((look.is_noted(obj), look.noted(obj)), (False, ""))
        self.assertEqual(self.look(obj), "")
        obj.location.x = 1.0
        bpy.context.view_layer.update()
        self.assertTrue(look.is_noted(obj))
        modifier.show_viewport = False
        self.assertFalse(look.is_noted(obj))

    def test_follow_waits_while_the_mesh_is_not_seen(self):
        obj = posable()
        modifier = add_nodes(obj, takes_places=True)
        scene = module("follow.scene").BlenderFollowScene(obj)
        with self.assertRaisesRegex(module("follow.run").NotNow, "^Paused: A pose of 'Tube' would not be seen"):
            scene._is_look_due(obj)
        modifier.show_viewport = False
        self.assertFalse(scene._is_look_due(obj))
        modifier.show_viewport = True
        with scene.evaluated(bpy.context.evaluated_depsgraph_get(), None):  # within a handler
            self.assertTrue(scene._is_look_due(obj))

    def test_clothes_that_are_not_seen_to_follow_are_told_in_their_list(self):
        body, sleeve = mesh_object("Body"), mesh_object("Sleeve")
        add_nodes(sleeve, takes_places=True)
        self.api.attach(body, [sleeve])
        (attachment,) = body.arap.attachments
        self.assertEqual(module("attach.linked_keys").why_hidden(body, sleeve), "")  # nothing is posed yet
        self.api.add_pin(body, BOTTOM)
        self.api.add_handle(body, TOP)
        self.api.solve(body)
        self.assertIn("A pose of 'Sleeve' would not be seen", module("attach.sync").problem_of(body, attachment))
