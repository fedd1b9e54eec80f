# SPDX-License-Identifier: GPL-3.0-or-later
"""Follow: the mesh follows its handles by itself. Without a window each evaluation is followed to the end."""

import contextlib
import io
from unittest import mock

import hostile
import numpy as np
import support
from looks import key_names, key_positions, rest_positions, shown_positions
from support import FakeLock, SceneTest, bpy, module, opened_again, uid
from tubes import (
    BOTTOM,
    MIDDLE,
    SEGMENTS,
    TOP,
    animate,
    bend,
    copied,
    empty_at,
    following_tube,
    mesh_object,
    move,
    posable,
)

SAME = 2e-3  # of a mesh 4 long: what two ways to one pose may differ by, at the accuracy below


def top_as_handled(obj):
    """The places of the top by the handle."""
    motion = module("scene.handle_motion").handle_matrices(obj)[1]
    return rest_positions(obj)[TOP] @ motion[:3, :3].T + motion[:3, 3]


class FollowToggleTest(SceneTest):
    def setUp(self):
        super().setUp()
        self.follow = module("follow.runs")
        self.sessions = module("core.sessions")

    def count_updates(self, obj):
        """How often the object's session has been asked to solve, from now on, in a list of one number."""
        session = self.sessions.get(obj.session_uid).session
        plain, count = session.update, [0]

        def update(*args, **keywords):
            count[0] += 1
            return plain(*args, **keywords)

        session.update = update
        return count

    def assert_followed(self, obj):
        self.assertEqual((obj.arap.use_follow, obj.arap.follow_error), (True, ""))
        shown = shown_positions(obj)
        self.assertTrue(np.isfinite(shown).all())
        self.assert_close(shown[TOP], top_as_handled(obj), 1e-5)
        self.assert_close(shown[BOTTOM], rest_positions(obj)[BOTTOM], 1e-5)

    def assert_off(self, obj, reason):
        self.assertEqual((obj.arap.use_follow, obj.arap.follow_error), (False, f"{reason}: Follow is off"))
        self.assertIsNone(self.follow.run_of(obj))

    def assert_solved(self, obj):
        """The pose is that of Solve: the defined start, to the accuracy."""
        shown = key_positions(obj)
        obj.arap.use_follow = False
        self.api.solve(obj)
        self.assert_close(shown, key_positions(obj), SAME)

    # ------------------------------------------------------------------------------------------------- following

    def test_a_moved_handle_is_followed_to_the_end(self):
        obj = following_tube()
        self.assertTrue(self.follow.run_of(obj).is_settled)
        bend(obj)
        self.assert_followed(obj)
        self.assert_solved(obj)

    def test_playback_and_scrubbing_follow_and_a_frame_looks_the_same_whichever_way_one_comes(self):
        obj = following_tube()
        animate(obj)
        seen = {}
        for frame in (*range(1, 22), 7, 20, 3, 11, 15, 1, 21, 2):
            self.scene.frame_set(frame)
            self.assert_followed(obj)
            shown = shown_positions(obj)
            self.assert_close(shown, seen.setdefault(frame, shown), 0.0)
        self.assertGreater(np.abs(seen[11] - seen[1]).max(), 1.0)
        self.scene.frame_set(11)
        self.assert_solved(obj)

    def test_what_did_not_change_is_not_solved(self):
        obj = following_tube()
        bend(obj)
        bystander = mesh_object("Bystander")
        count = self.count_updates(obj)
        for step in range(3):
            bystander.location.x += 1.0
            bpy.context.view_layer.update()
            obj.location.y += 1.0  # the empties are its children
            bpy.context.view_layer.update()
            self.scene.frame_set(step + 5)
        self.assertEqual(count, [0])
        self.assert_followed(obj)
        bend(obj)
        self.assertEqual(count, [1])

    def test_several_objects_follow_their_own_handles(self):
        objects = [following_tube(f"Tube {i}") for i in range(3)]
        for obj in objects[1:]:  # the first one rests
            animate(obj)
        for frame in (5, 11, 21):
            self.scene.frame_set(frame)
            for obj in objects:
                self.assert_followed(obj)
        counts = [self.count_updates(obj) for obj in objects]
        move(objects[1].arap.handles[0].target, (0.1, 0.0, 0.0))
        self.assertEqual(counts, [[0], [1], [0]])

    # -------------------------------------------------------------------------------------- files, renders, other acts

    def test_saved_with_the_file_and_at_work_after_load(self):
        obj = following_tube()
        animate(obj)
        self.scene.frame_set(11)
        shown = shown_positions(obj)
        path = str(self.new_folder() / "live.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        self.assertEqual(self.follow._runs, {})
        bpy.ops.wm.open_mainfile(filepath=path)
        obj = bpy.data.objects["Tube"]
        self.assertTrue(obj.arap.use_follow)
        self.assert_close(shown_positions(obj), shown, 1e-6)
        bpy.context.scene.frame_set(21)
        self.assert_followed(obj)
        bpy.context.scene.frame_set(11)
        self.assert_close(shown_positions(obj), shown, SAME)

    def test_an_opened_file_binds_and_changes_nothing_before_something_moves(self):
        for was_posed in (True, False):
            with self.subTest(was_posed=was_posed):
                bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
                obj = following_tube()
                animate(obj)
                bpy.context.scene.frame_set(11)
                if not was_posed:
                    obj.shape_key_clear()
                before = key_names(obj), shown_positions(obj)
                obj = opened_again()
                for _ in range(2):
                    obj.location.x += 1.0
                    bpy.context.view_layer.update()
                    bpy.context.scene.frame_set(11)
                is_bound = self.sessions.get(uid("Tube")) is not None
                self.assertEqual((is_bound, key_names(obj), bpy.data.is_dirty), (False, before[0], self.new_is_dirty))
                self.assert_close(shown_positions(obj), before[1], 0.0)
                run = self.follow.run_of(obj)
                self.assertTrue(run.is_settled)
                move(obj.arap.handles[0].target, (0.1, 0.0, 0.0))
                self.assert_followed(obj)

    def test_an_opened_file_without_handles_waits_too(self):
        obj = mesh_object()
        obj.arap.follow_error = ""  # so that there is something stored
        hostile.write(obj, use_follow=True)  # Follow does not hear of it
        obj = opened_again()
        self.assertEqual((obj.arap.use_follow, obj.arap.follow_error), (True, ""))
        obj.location.x += 1.0
        bpy.context.view_layer.update()
        self.assertTrue(self.follow.run_of(obj).is_settled)

    def test_an_opened_file_follows_changed_weights_and_settings_too(self):
        def paint(obj):
            obj.vertex_groups["Head"].remove(TOP[:2])

        def stiffen(obj):
            obj.arap.rigidity = 5.0

        for change in (paint, stiffen):
            bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
            bend(following_tube())
            obj = opened_again()
            shown = shown_positions(obj)
            change(obj)
            obj.data.update_tag()
            bpy.context.view_layer.update()
            self.assertGreater(np.abs(shown_positions(obj) - shown).max(), 1e-3)

    def test_a_mesh_that_does_not_settle_holds_no_script_for_ever(self):
        obj = following_tube()
        limit = mock.patch.object(module("follow.scene"), "SCRIPT_TIME_LIMIT_S", 1e-9)
        with limit, contextlib.redirect_stdout(io.StringIO()):
            bend(obj)
        self.assert_off(obj, "'Tube' has not settled within 1e-09 seconds (raise Accuracy in Advanced)")

    def test_a_bind_that_a_file_load_ends_gives_no_session_to_the_new_file(self):
        obj = following_tube()
        former = self.sessions.get(uid("Tube"))
        self.sessions.drop(uid("Tube"))  # it is bound again, and the thread has not begun
        self.follow.run_of(obj)._tracker.drop = lambda: self.sessions.put(uid("Tube"), former)
        for function in list(bpy.app.handlers.load_post):  # what Blender does next is to evaluate: one would be bound
            if function.__module__.startswith(support.PACKAGE):
                function("")
        self.assertIsNone(self.sessions.get(uid("Tube")))

    def test_appended_it_works_and_linked_it_shows_what_was_saved(self):
        obj = following_tube()
        bend(obj)
        shown = key_positions(obj)
        path = str(self.new_folder() / "live.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        for is_linked in (False, True):
            bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
            with bpy.data.libraries.load(path, link=is_linked) as (source, wanted):
                wanted.objects = source.objects
            for item in wanted.objects:
                bpy.context.scene.collection.objects.link(item)
            bpy.context.view_layer.update()
            obj = bpy.data.objects["Tube"]
            self.assertEqual(self.follow.run_of(obj) is None, is_linked)
            self.assert_close(shown_positions(obj), shown, SAME)
            self.assertEqual((obj.arap.use_follow, obj.arap.follow_error), (True, ""))
            if not is_linked:
                move(obj.arap.handles[0].target, (0.2, 0.0, 0.0))
                self.assert_followed(obj)

    def update_quietly(self):
        """Evaluates the scene; what is printed without a window is one line."""
        with contextlib.redirect_stdout(io.StringIO()) as said:
            bpy.context.view_layer.update()
            bpy.context.view_layer.update()
            self.scene = bpy.context.scene
            self.scene.frame_set(self.scene.frame_current + 1)
        self.assertEqual(said.getvalue().count("\n"), 1, said.getvalue())
        self.assertTrue(said.getvalue().startswith("ARAP: "))

    def test_off_while_rendering_and_says_so(self):
        obj = following_tube()
        animate(obj)
        self.scene.frame_set(11)
        shown = shown_positions(obj)
        camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        self.scene.collection.objects.link(camera)
        self.scene.camera = camera
        self.scene.render.engine = "BLENDER_WORKBENCH"
        self.scene.render.resolution_x = self.scene.render.resolution_y = 16
        self.scene.frame_start, self.scene.frame_end = 20, 21
        count = self.count_updates(obj)
        self.scene.render.filepath = str(self.new_folder() / "frame_")
        with contextlib.redirect_stdout(io.StringIO()) as said:
            in_render = []
            bpy.app.handlers.render_post.append(lambda *_: in_render.append(tuple(count)))
            bpy.ops.render.render(animation=True)
            bpy.app.handlers.render_post.pop()
        self.assertEqual(in_render, [(0,), (0,)])
        notice = "Rendered without Follow: the mesh kept one shape. Bake the animation before rendering it"
        self.assertEqual(self.follow.render_notice(), notice)
        self.assertEqual(said.getvalue().count(f"ARAP: {notice}"), 1)
        self.assertEqual(self.scene.frame_current, 11)
        self.assert_close(shown_positions(obj), shown, 0.0)
        self.scene.frame_set(5)
        self.assert_followed(obj)
        bpy.ops.render.render()
        self.assertEqual(self.follow.render_notice(), "", "a still shows the pose of its frame")

    def test_waits_while_the_object_is_posed_or_baked(self):
        obj = following_tube()
        act = FakeLock("it is posed")
        self.sessions.lock(bpy.data.objects["Tube"], act)
        count = self.count_updates(obj)
        bend(obj)
        self.assertEqual((count, self.follow.run_of(obj).pause), ([0], "Paused while it is posed"))
        self.sessions.unlock(uid("Tube"), act)
        bpy.context.view_layer.update()
        self.scene.frame_set(2)
        self.assert_followed(obj)

    def test_after_an_act_that_has_bound_it_otherwise_it_follows_again(self):
        obj = following_tube()
        bend(obj)
        state = module("pose.result").capture_state(obj)
        act = FakeLock("it is posed")
        self.sessions.lock(bpy.data.objects["Tube"], act)
        obj.arap.rigidity = 20.0
        bpy.context.view_layer.update()
        self.sessions.unlock(uid("Tube"), act)
        self.api.prepare_session(obj)
        module("pose.result").restore_state(obj, state)
        bpy.context.view_layer.update()
        self.scene.frame_set(2)
        self.assert_solved(obj)

    def test_a_rename_that_is_undone_in_another_scene_leaves_it_on(self):
        obj = following_tube()
        obj.name = "Renamed"
        self.follow.undone(bpy.data.scenes.new("Other"))
        self.assertEqual((obj.arap.use_follow, obj.arap.follow_error), (True, ""))
        self.assertIsNotNone(self.follow.run_of(obj))

    def test_a_bake_has_the_mesh_for_itself_and_pauses_it_until_edit_again(self):
        obj = following_tube()
        animate(obj)
        other = following_tube("Other")
        animate(other)
        job = module("bake.keys").BakeJob(obj, 1, 11, 5)
        count = self.count_updates(other)
        while job.step():
            self.assertIn(self.sessions.locked_by(uid("Tube")), "it is baked")
        self.assertGreater(count[0], 0, "another one follows meanwhile")
        job.finish()
        self.assertEqual(self.sessions.locked_by(uid("Tube")), "")
        bend(obj)
        run = self.follow.run_of(obj)
        self.assertEqual((run.pause, obj.arap.follow_error), ("Paused: the bake is shown. Edit Again goes on", ""))
        module("scene.baked").edit_again(obj)
        self.scene.frame_set(7)
        self.assert_followed(obj)
        self.assert_followed(other)
        job = module("bake.keys").BakeJob(other, 1, 11, 5)
        job.cancel()
        self.assertEqual(self.sessions.locked_by(uid("Other")), "")

    # ------------------------------------------------------------------------------------------ what happens to a scene

    def test_a_missing_handle_switches_off_once_and_keeps_the_pose(self):
        obj = following_tube()
        bend(obj)
        posed = key_positions(obj)
        bpy.data.objects.remove(obj.arap.handles[0].target)
        self.update_quietly()
        self.assert_off(obj, "Handle 'Head' of 'Tube': it has no object; choose one or remove the handle")
        self.assert_close(key_positions(obj), posed, 0.0)
        obj.arap.use_follow = False
        self.assertEqual(obj.arap.follow_error, "", "a toggle by hand takes the reason away")

    def test_an_unforeseen_error_switches_off_too(self):
        obj = following_tube()
        self.sessions.get(uid("Tube")).session.update = None
        with contextlib.redirect_stderr(io.StringIO()) as said:
            bend(obj)
            bend(obj)
        self.assertEqual(said.getvalue().count("Traceback"), 1)
        self.assert_off(obj, "'NoneType' object is not callable")

    def test_edit_mode_pauses_and_another_mesh_is_taken_up(self):
        obj = following_tube()
        bend(obj)
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.context.view_layer.update()
        self.assertEqual(self.follow.run_of(obj).pause, "Paused in Edit Mode")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.mesh.subdivide()
        move(obj.arap.handles[0].target, (0.0, 0.3, 0.0))
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.context.view_layer.update()
        self.assertEqual((self.follow.run_of(obj).pause, obj.arap.follow_error), ("", ""))
        self.assert_followed(obj)
        self.assertEqual(len(shown_positions(obj)), len(obj.data.vertices))

    def test_weights_settings_pins_and_scale_take_effect(self):
        obj = following_tube()
        group = obj.vertex_groups.new(name="Waist")
        group.add(MIDDLE, 1.0, "REPLACE")
        self.api.add_pin_group(obj, "Waist")
        bend(obj)
        self.assert_close(shown_positions(obj)[MIDDLE], rest_positions(obj)[MIDDLE], 1e-5)
        group.remove(MIDDLE[:4])
        bpy.context.view_layer.update()
        self.assertGreater(np.abs(shown_positions(obj) - rest_positions(obj))[MIDDLE[:4]].max(), 1e-3)
        obj.arap.pins[1].is_enabled = False
        obj.scale.z = 1.5
        bpy.context.view_layer.update()
        self.assert_followed(obj)
        self.assert_solved(obj)

    def test_excluded_it_waits_and_comes_back(self):
        obj = following_tube()
        obj.hide_viewport = True
        bpy.context.view_layer.update()
        move(obj.arap.handles[0].target, (0.0, 0.5, 0.0))
        self.assertEqual(self.follow.run_of(obj).pause, "Paused: this mesh is disabled, excluded or in another scene")
        obj.hide_viewport = False
        bpy.context.view_layer.update()
        self.assert_followed(obj)

    def test_what_is_added_or_chosen_moves_nothing_and_is_followed_then(self):
        knee, other = list(range(4 * SEGMENTS, 5 * SEGMENTS)), (0.3, 0.8, 2.0)
        for name, act in {
            "pin": lambda obj: self.api.add_pin(obj, MIDDLE),
            "pin of a group": lambda obj: self.api.add_pin_group(obj, "Head"),
            "handle": lambda obj: self.api.add_handle(obj, knee),
            "handle for an object": lambda obj: self.api.add_handle_for(obj, empty_at(other)),
            "another object": lambda obj: setattr(obj.arap.handles[0], "target", empty_at(other)),
        }.items():
            with self.subTest(act=name):
                self.setUp()
                obj = following_tube()
                bend(obj)
                before = shown_positions(obj)
                act(obj)
                bpy.context.view_layer.update()
                self.assert_close(shown_positions(obj), before, SAME)
                self.assertEqual(obj.arap.follow_error, "")
                move(obj.arap.handles[-1].target, (0.0, 0.2, 0.0))
                self.assertGreater(np.abs(shown_positions(obj) - before).max(), 0.05)

    def test_renamed_it_goes_on_and_deleted_it_is_forgotten(self):
        obj = following_tube()
        session = self.sessions.get(obj.session_uid).session
        obj.name = "Pipe"
        bpy.context.view_layer.update()
        bend(obj)
        self.assert_followed(obj)
        self.assertIs(self.sessions.get(obj.session_uid).session, session, "nothing was bound again")
        former = obj.session_uid
        self.assertEqual(list(self.follow._runs), [former])
        bpy.data.objects.remove(obj)
        bpy.context.view_layer.update()
        self.assertEqual((list(self.follow._runs), self.sessions.get(former)), ([], None))

    def keys(self, obj):
        return [(key.name, key.value) for key in obj.data.shape_keys.key_blocks if key.name != "Basis"]

    def test_a_renamed_key_stays_the_pose_even_if_it_is_renamed_in_edit_mode(self):
        obj = following_tube()
        bpy.context.view_layer.objects.active = obj
        for mode, name in (("OBJECT", "Grip"), ("EDIT", "Grab"), ("OBJECT", "Hold")):
            bend(obj)
            bpy.ops.object.mode_set(mode=mode)
            obj.data.shape_keys.key_blocks[obj.arap.key_name].name = name
            bpy.ops.object.mode_set(mode="OBJECT")
            move(obj.arap.handles[0].target, (0.1, 0.0, 0.0))
            self.assert_followed(obj)
            self.assertEqual(self.keys(obj), [(name, 1.0)])
            self.assertEqual((obj.arap.key_name, [key.name for key in obj.arap.made_keys]), (name, [name]))

    def test_after_an_undo_of_a_renaming_the_key_is_still_the_pose(self):
        obj = following_tube()
        bend(obj)
        bpy.ops.ed.undo_push(message="bent")
        obj.data.shape_keys.key_blocks["ARAP"].name = "Grip"
        move(obj.arap.handles[0].target, (0.1, 0.0, 0.0))
        bpy.ops.ed.undo_push(message="renamed")
        for act, name in ((bpy.ops.ed.undo, "ARAP"), (bpy.ops.ed.redo, "Grip")):
            act()
            obj = bpy.data.objects["Tube"]
            bpy.context.view_layer.update()
            move(obj.arap.handles[0].target, (0.1, 0.0, 0.0))
            self.assert_followed(obj)
            self.assertEqual([key for key, _ in self.keys(obj)], [name])

    def test_switched_on_in_edit_mode_it_makes_the_key_later(self):
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.mode_set(mode="EDIT")
        obj.arap.use_follow = True
        self.assertIsNone(obj.data.shape_keys)
        bpy.ops.object.mode_set(mode="OBJECT")
        bend(obj)
        self.assert_followed(obj)

    def test_a_removed_key_is_made_again_and_no_other_one_is_taken_for_it(self):
        obj = following_tube()
        bend(obj)
        obj.shape_key_remove(obj.data.shape_keys.key_blocks["ARAP"])
        bpy.context.view_layer.update()
        obj.shape_key_add(name="Mine", from_mix=False).value = 0.0
        move(obj.arap.handles[0].target, (0.1, 0.0, 0.0))
        self.assert_followed(obj)
        self.assertEqual(sorted(self.keys(obj)), [("ARAP", 1.0), ("Mine", 0.0)])

    def test_a_key_with_a_former_name_of_a_removed_one_is_the_artists(self):
        obj = following_tube()
        bend(obj)
        obj.data.shape_keys.key_blocks["ARAP"].name = "Grip"
        bpy.context.view_layer.update()
        own = obj.shape_key_add(name="ARAP", from_mix=False)
        own.value, own.data[0].co.x = 0.0, 7.0
        bpy.context.view_layer.update()
        obj.shape_key_remove(obj.data.shape_keys.key_blocks["Grip"])
        bpy.context.view_layer.update()
        move(obj.arap.handles[0].target, (0.1, 0.0, 0.0))
        self.assertEqual(sorted(self.keys(obj)), [("ARAP", 0.0), ("Grip", 1.0)])
        self.assertEqual(obj.data.shape_keys.key_blocks["ARAP"].data[0].co.x, 7.0)
        self.assertEqual([key.name for key in obj.arap.made_keys], ["Grip"])

    def test_another_name_for_the_key_switches_off_before_the_pose_shows_twice(self):
        obj = following_tube()
        bend(obj)
        posed = shown_positions(obj)
        obj.arap.key_name = "Bent"
        with contextlib.redirect_stdout(io.StringIO()):
            bend(obj)
        self.assert_off(obj, "The pose of 'Tube' has another shape key now, and is kept in 'ARAP'")
        self.assert_close(shown_positions(obj), posed, 0.0)

    def test_a_copy_is_not_torn_towards_the_handles_of_the_original(self):
        obj = following_tube()
        bend(obj)
        with contextlib.redirect_stdout(io.StringIO()):
            copy = copied(obj)
            posed = shown_positions(copy)
            copy.location.x += 10.0
            move(obj.arap.handles[0].target, (0.2, 0.0, 0.0))
        self.assert_followed(obj)
        self.assert_close(shown_positions(copy), posed, 0.0)
        self.assert_off(
            copy,
            "Handle 'Head' of 'Tube.001': its empty belongs to 'Tube', of which this is a copy; press Copy Handles",
        )
        move(obj.arap.handles[0].target, (-0.2, 0.0, 0.0))
        self.api.copy_handles(copy)
        self.assertEqual(copy.arap.follow_error, "")
        copy.arap.use_follow = True
        bpy.context.view_layer.update()
        self.assert_followed(copy)
        self.assert_close(shown_positions(copy), posed, SAME)
        move(copy.arap.handles[0].target, (0.3, 0.0, 0.0))
        self.assert_followed(copy)
        self.assert_close(shown_positions(obj), posed, SAME)

    def test_a_linked_duplicate_pauses_both_until_each_has_its_own_mesh(self):
        obj = following_tube()
        bend(obj)
        posed = key_positions(obj)
        twin = obj.copy()
        bpy.context.scene.collection.objects.link(twin)
        bpy.context.view_layer.update()
        move(obj.arap.handles[0].target, (0.2, 0.0, 0.0))
        self.assertEqual((obj.arap.use_follow, obj.arap.follow_error, twin.arap.use_follow), (True, "", True))
        for each in (obj, twin):
            self.assertRegex(self.follow.run_of(each).pause, "^Paused: The mesh of '.*' is shared with other objects")
        self.assert_close(key_positions(obj), posed, 0.0)
        bpy.data.objects.remove(twin)
        bpy.context.view_layer.update()
        self.assert_followed(obj)

    def test_a_fault_with_one_mesh_keeps_no_other_from_following(self):
        broken, obj = following_tube("Broken"), following_tube()
        self.follow.run_of(broken).settle = None
        with contextlib.redirect_stderr(io.StringIO()) as said:
            bend(obj)
        self.assertIn("TypeError", said.getvalue())
        self.assert_followed(obj)

    def test_a_copy_made_together_with_its_handles_follows_those(self):
        obj = following_tube()
        bend(obj)
        for item in (obj, obj.arap.handles[0].target):
            item.select_set(True)
        bpy.ops.object.duplicate()
        copy, handle = bpy.data.objects["Tube.001"], bpy.data.objects["Head.001"]
        self.assertEqual((copy.arap.handles[0].target, handle.parent), (handle, copy))
        copy.location.x += 10.0
        move(handle, (0.3, 0.0, 0.0))
        self.assert_followed(copy)
        self.assert_followed(obj)

    def test_reset_takes_handles_and_mesh_to_rest_with_and_without_follow(self):
        for use_follow in (True, False):
            self.setUp()
            obj = following_tube()
            bpy.context.view_layer.objects.active = obj
            move(obj.arap.handles[0].target, (0.3, 0.0, 0.0))
            self.assert_followed(obj)
            obj.arap.use_follow = use_follow
            self.assertEqual(bpy.ops.arap.reset(), {"FINISHED"})
            bpy.context.view_layer.update()
            self.assert_close(key_positions(obj), rest_positions(obj), 1e-5)
            self.assert_close(module("scene.handle_motion").handle_matrices(obj)[-1], np.eye(4), 1e-6)

    def test_apply_pose_as_rest_goes_on_from_the_new_rest(self):
        obj = following_tube()
        bend(obj)
        posed = shown_positions(obj)
        self.api.apply_pose_as_rest(obj)
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(obj), posed, 1e-5)
        move(obj.arap.handles[0].target, (0.3, 0.0, 0.0))
        self.assert_followed(obj)
