# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on does when Blender tells of changes: once for all, and for objects that it knows alone."""

import contextlib
import io
import sys
from unittest import mock

import numpy as np
import support
from looks import shown_positions
from mathutils import Matrix
from support import SceneTest, bpy, linked_back, module
from tubes import BOTTOM, TOP, bend, empty_at, following_tube, mesh_object, move

LISTS = ("depsgraph_update_post", "frame_change_post", "undo_post", "redo_post", "load_post")


def own_handlers(name):
    return [each for each in getattr(bpy.app.handlers, name) if each.__module__.startswith(support.PACKAGE)]


class EarsTest(SceneTest):
    def test_one_handler_each(self):
        following_tube()
        self.assertEqual({name: len(own_handlers(name)) for name in LISTS}, dict.fromkeys(LISTS, 1))

    def n_calls(self, n_objects):
        """Calls of the handler of evaluations while so many objects move, none of them ours."""
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        top = empty_at((0.0, 0.0, 0.0))
        for i in range(n_objects):
            child = bpy.data.objects.new(f"Child {i}", None)
            child.parent = top
            bpy.context.scene.collection.objects.link(child)
        mesh_object()
        module("scene.ui_cache").owner_of(bpy.context.view_layer, top)
        (handler,) = own_handlers("depsgraph_update_post")
        calls = []

        def counted(scene, depsgraph):
            self.assertGreater(len(depsgraph.updates), n_objects)
            sys.setprofile(lambda _frame, event, _arg: calls.append(event) if event in {"call", "c_call"} else None)
            try:
                handler(scene, depsgraph)
            finally:
                sys.setprofile(None)

        functions = bpy.app.handlers.depsgraph_update_post
        functions[functions.index(handler)] = counted
        try:
            top.location.x += 1.0
            bpy.context.view_layer.update()
        finally:
            functions[functions.index(counted)] = handler
        return len(calls)

    def test_without_an_object_of_ours_it_returns_at_once(self):
        few, many = self.n_calls(10), self.n_calls(10_000)
        self.assertGreater(few, 0)
        self.assertEqual(few, many)

    def test_a_fault_with_one_object_keeps_no_other_from_its_turn(self):
        tubes = [following_tube("A"), following_tube("B")]
        applied = module("engine.applied")
        plain, looked = applied.look, []

        def look(obj):
            looked.append(obj.name)
            if obj == tubes[0]:
                raise RuntimeError("a fault")
            plain(obj)

        with mock.patch.object(applied, "look", look), contextlib.redirect_stderr(io.StringIO()) as said:
            for obj in tubes:
                obj.location.x += 1.0
            bpy.context.view_layer.update()
        self.assertLessEqual({"A", "B"}, set(looked))
        self.assertIn("RuntimeError: a fault", said.getvalue())


class IdentityTest(SceneTest):
    def setUp(self):
        super().setUp()
        self.known, self.follow = module("scene.known"), module("follow.runs")

    def test_meshes_that_swap_their_names_keep_their_shapes(self):
        a, b = following_tube("A"), mesh_object("B")
        b.data.transform(Matrix.Scale(2.0, 4))
        self.api.add_pin(b, BOTTOM)
        self.api.add_handle(b, TOP)
        b.arap.use_follow = True
        for obj in (a, b):
            bend(obj)
        a.name = "Other"
        b.name = "A"
        a.name = "B"
        for obj, width in ((a, 1.0), (b, 2.0)):
            move(obj.arap.handles[0].target, (0.1, 0.0, 0.0))
            self.assert_close(np.ptp(shown_positions(obj)[BOTTOM, 0]), width, 1e-4)

    def test_a_copy_that_takes_the_place_of_its_original_follows(self):
        """The file has as many objects as before."""
        obj = following_tube()
        copy = obj.copy()
        copy.data = obj.data.copy()
        self.scene.collection.objects.link(copy)
        bpy.data.objects.remove(obj)
        bpy.context.view_layer.update()
        self.assertEqual(list(self.follow._runs), [copy.session_uid])

    def test_as_many_objects_appended_as_removed_are_seen(self):
        obj = following_tube()
        path = str(self.new_folder() / "tube.blend")
        bpy.data.libraries.write(path, {obj})
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        others = [empty_at((0.0, 0.0, 0.0), f"Other {i}") for i in range(2)]
        for other in others:
            bpy.data.objects.remove(other)
        with bpy.data.libraries.load(path) as (_, data):
            data.objects = ["Tube"]
        for new in bpy.data.objects:
            bpy.context.scene.collection.objects.link(new)
        self.assertEqual(len(bpy.data.objects), 2)
        bpy.context.view_layer.update()
        self.assertEqual(list(self.follow._runs), [bpy.data.objects["Tube"].session_uid])

    def test_a_linked_object_is_found_by_its_uid_beside_a_local_one_of_its_name(self):
        (linked,) = linked_back(mesh_object(), "Tube")
        local = mesh_object()
        self.scene = bpy.context.scene
        self.scene.collection.objects.link(linked)
        self.assertEqual(local.name, linked.name)
        for obj in (linked, local):
            uid = self.known.add(obj)
            self.assertEqual((self.known.find(uid), self.known.find_in(self.scene, uid)), (obj, obj))
        self.scene.collection.objects.unlink(linked)
        self.assertIsNone(self.known.find_in(self.scene, linked.session_uid))

    def test_what_is_removed_is_forgotten_and_what_undo_brings_is_known(self):
        obj = following_tube()
        uid = obj.session_uid
        bpy.ops.ed.undo_push(message="there")
        bpy.data.objects.remove(obj)
        bpy.context.view_layer.update()
        bpy.ops.ed.undo_push(message="gone")
        self.assertIsNone(self.known.find(uid))
        self.assertNotIn(uid, self.known._keys)
        bpy.ops.ed.undo()
        self.assertEqual(self.known.find(uid), bpy.data.objects["Tube"])
        self.assertEqual(list(self.follow._runs), [uid])
