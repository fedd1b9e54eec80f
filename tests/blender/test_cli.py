# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line, on real files: in this process, and in a Blender of its own."""

import contextlib
import io
import shutil
import subprocess
import sys
import types
import unittest.mock
from pathlib import Path

import numpy as np
import support
from looks import key_names, key_positions, rest_positions, shown_positions
from mathutils import Matrix
from support import SceneTest, bpy, module
from tubes import BOTTOM, MIDDLE, TOP, animate, armature, empty_at, mesh_object, posable


class CliTest(SceneTest):
    def setUp(self) -> None:
        super().setUp()
        self.folder = self.new_folder()
        self.input = self.folder / "input.blend"
        self.output = self.folder / "output.blend"

    def save_scene(self) -> None:
        obj = posable()
        obj.arap.accuracy = 1e-5
        target = obj.arap.handles[0].target
        target.keyframe_insert("location", frame=1)
        target.location.y += 1.0
        target.keyframe_insert("location", frame=11)
        self.scene.frame_start, self.scene.frame_end = 1, 11
        self.scene.frame_set(1)
        bpy.ops.wm.save_as_mainfile(filepath=str(self.input))

    def run_cli(self, *arguments) -> tuple[int, str, str]:
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = module("cli").main([str(argument) for argument in arguments])
        return code, out.getvalue(), err.getvalue()

    def done(self, *arguments) -> tuple[str, bpy.types.Object]:
        """Runs a command that must succeed on the input; what it printed, and the object in the output."""
        code, out, err = self.run_cli(*arguments, "-o", self.output)
        self.assertEqual((code, err), (0, ""))
        self.assertEqual(module("core.sessions")._bound, {}, "what it has bound it gives back")
        self.assertTrue(out.endswith(f"Saved {self.output}\n"))
        return out, self.load(self.output)

    def assert_top_has_moved(self, obj, positions) -> None:
        self.assert_close(positions[TOP], rest_positions(obj)[TOP] + np.array([0.0, 1.0, 0.0]))

    def load(self, path: Path) -> bpy.types.Object:
        bpy.ops.wm.open_mainfile(filepath=str(path))
        return bpy.data.objects["Tube"]

    def assert_failed(self, reason: str, *arguments, code: int = 1) -> None:
        self.assertEqual(self.run_cli(*arguments), (code, "", f"arap: {reason}\n"))

    def test_pose_at_a_frame_and_save_to_a_new_file(self):
        self.save_scene()
        before = self.input.read_bytes()
        out, obj = self.done("pose", self.input, "--frame", 11)
        self.assertRegex(out, r"^Tube: 136 vertices, \d+ iterations, converged, \d+ ms\n")
        self.assertEqual(self.input.read_bytes(), before)
        self.assert_top_has_moved(obj, key_positions(obj))
        self.assertEqual(bpy.context.scene.frame_current, 11)

    def test_bake_a_range_and_tell_how_many_frames_have_not_settled(self):
        self.save_scene()
        out, obj = self.done("bake", self.input, "--start", 1, "--end", 11, "--step", 5)
        self.assertTrue(out.startswith("Tube: 3 keys, 'ARAP_0001' to 'ARAP_0011'\n"))
        bpy.context.scene.frame_set(11)
        self.assert_top_has_moved(obj, shown_positions(obj))
        self.load(self.input).arap.max_iterations = 1
        bpy.ops.wm.save_as_mainfile(filepath=str(self.input))
        self.output.unlink()
        out, _ = self.done("bake", self.input, "--step", 5)
        self.assertRegex(out, r"^Tube: 3 keys, 'ARAP_0001' to 'ARAP_0011', 2 before the accuracy was reached\n")

    def test_bake_takes_the_scenes_range_and_a_prefix(self):
        self.save_scene()
        _, obj = self.done("bake", self.input, "--prefix", "Walk ")
        names = key_names(obj)
        self.assertEqual(names, ["Basis", *(f"Walk {frame:04d}" for frame in range(1, 12))])

    def test_bake_the_fewest_keys(self):
        self.save_scene()
        out, obj = self.done("bake", self.input, "--fewest-keys", 1.5)
        self.assertRegex(out, r"^Tube: (\d+) keys for 11 frames, .*[01]\.\d{3} % .*, 'ARAP_0001' to 'ARAP_0011'\n")
        n_keys = len(obj.data.shape_keys.key_blocks) - 1
        self.assertEqual(n_keys, int(out.split()[1]))
        self.assertLess(n_keys, 8)

    def test_bake_to_a_cache(self):
        """The .blend plays it from wherever the two are."""
        self.save_scene()
        cache = self.folder / "cache" / "tube.pc2"
        cache.parent.mkdir()
        self.output = self.folder / "elsewhere" / "output.blend"
        self.output.parent.mkdir()
        arguments = ["bake", self.input, "--start", 3, "--end", 11, "--cache", cache]
        out, obj = self.done(*arguments)
        self.assertTrue(out.startswith(f"Tube: 9 frames in {cache}\n"))
        self.assertIsNone(obj.data.shape_keys)
        bpy.context.scene.frame_set(11)
        self.assert_top_has_moved(obj, shown_positions(obj))
        self.output.unlink()
        message = f"{cache} exists already: give another file, or --overwrite to write over it"
        self.assert_failed(message, *arguments, "-o", self.output)
        self.done(*arguments, "--overwrite")

    def test_shape_keys_of_the_stored_poses(self):
        self.save_scene()
        self.assert_failed("'Tube' has no stored poses: store one first", "keys", self.input, "-o", self.output)
        self.load(self.input)
        bpy.context.scene.frame_set(11)
        self.api.store_pose(bpy.data.objects["Tube"], "Far")
        posable("Other")  # without poses: passed over
        bpy.ops.wm.save_as_mainfile(filepath=str(self.input))
        out, obj = self.done("keys", self.input)
        self.assertTrue(out.startswith("Tube: keys 'Far'\n"))
        self.assert_top_has_moved(obj, key_positions(obj, "Far"))

    def test_bake_one_frame(self):
        self.save_scene()
        out, obj = self.done("bake", self.input, "--frame", 11)
        self.assertRegex(out, r"^Tube: 136 vertices, .* ms, key 'ARAP_0011'\n")
        self.assert_top_has_moved(obj, key_positions(obj, "ARAP_0011"))

    def test_the_defaults_are_the_open_file_and_all_objects_with_handles(self):
        posable("Other")
        self.save_scene()
        out, _ = self.done("pose")
        self.assertIn("Other: ", out)
        message = "--cache takes one object, but 2 have handles: name it with --object"
        self.output.unlink()
        self.assert_failed(message, "bake", self.input, "-o", self.output, "--cache", self.folder / "a.mdd")
        out, _ = self.done("pose", self.input, "--object", "Tube")
        self.assertNotIn("Other: ", out)
        self.assertIsNone(bpy.data.objects["Other"].data.shape_keys)

    def test_nothing_is_written_over_unless_told(self):
        self.save_scene()
        before = self.input.read_bytes()
        remedy = "give another file with -o, or --overwrite to write over it"
        self.assert_failed(f"{self.input} is the input: {remedy}", "pose", self.input)
        self.assert_failed(f"{self.input} is the input: {remedy}", "pose", self.input, "-o", self.input)
        self.assert_failed(f"{self.input} is the input: {remedy}", "pose")
        self.output.write_text("mine")
        self.assert_failed(f"{self.output} exists already: {remedy}", "pose", self.input, "-o", self.output)
        self.assertEqual(self.output.read_text(), "mine")
        self.assertEqual(self.input.read_bytes(), before)
        self.assertEqual(self.run_cli("pose", self.input, "--frame", 11, "--overwrite")[0], 0)
        after = self.input.read_bytes()
        self.assertNotEqual(after, before)
        kept, older = (self.folder / f"input.blend{n}" for n in (1, 2))
        self.assertEqual(kept.read_bytes(), before, "as Blender keeps it")
        bpy.context.preferences.filepaths.save_version = 2
        self.assertEqual(self.run_cli("pose", self.input, "--frame", 11, "--overwrite")[0], 0)
        self.assertEqual((kept.read_bytes(), older.read_bytes()), (after, before))
        self.assertIn("ARAP", self.load(self.input).data.shape_keys.key_blocks)

    def test_failures_give_one_line_and_a_code(self):
        missing, nowhere = self.folder / "missing.blend", self.folder / "nowhere"
        self.assert_failed("No .blend was given: name one", "pose", "-o", self.output)
        self.assert_failed(f"{missing} does not exist: check the path", "pose", missing, "-o", self.output)
        self.save_scene()
        for flags in ((), ("--overwrite",)):  # before any frame is solved
            arguments = ("bake", self.input, "-o", nowhere / "a.blend", *flags)
            self.assert_failed(f"{nowhere} is not a folder: make it first", *arguments)
        message = "There is no object 'Tail' in scene 'Scene': check its name"
        self.assert_failed(message, "pose", self.input, "-o", self.output, "--object", "Tail")
        cache = ("--cache", self.folder / "a.mdd")
        for message, options in (
            ("--frame bakes one frame, --start and --end a range: give one or the other", ("--frame", 1, "--end", 5)),
            (
                "--frame bakes one frame, --cache and --fewest-keys are for a range: leave one out",
                ("--frame", 1, "--fewest-keys", 1),
            ),
            ("--cache makes no shape keys: leave out --fewest-keys and --prefix", (*cache, "--fewest-keys", 1)),
            ("The last frame 1 is before the first, 5: swap them", ("--start", 5, "--end", 1)),
        ):
            self.assert_failed(message, "bake", self.input, "-o", self.output, *options)
        self.assertFalse(self.output.exists())

    def test_a_wrong_command_line_gives_one_line_and_code_2(self):
        self.assert_failed("the following arguments are required: command", code=2)
        self.assert_failed("unrecognized arguments: --fast", "pose", "--fast", code=2)
        self.assert_failed("argument --step: invalid int value: 'x'", "bake", "--step", "x", code=2)
        code, out, _ = self.run_cli("bake", "--help")
        self.assertEqual((code, "--start" in out), (0, True))

    def test_a_file_that_cannot_be_read_fails(self):
        broken = self.folder / "broken.blend"
        broken.write_text("this is not a .blend")
        code, _, err = self.run_cli("pose", broken, "-o", self.output)
        self.assertEqual(code, 1)
        self.assertRegex(err, r"^arap: \S+broken.blend cannot be opened \(.+\): give a \.blend of this Blender\n$")
        self.assertEqual(list(self.folder.iterdir()), [broken])

    def test_all_that_is_wrong_is_told_before_any_frame(self):
        """With every mesh: not the first broken handle after the others were solved."""
        posable("Other")
        self.save_scene()
        tube, other = bpy.data.objects["Tube"], bpy.data.objects["Other"]
        tube.arap.controls[self.api.add_handle(tube, MIDDLE, name="Belt")].target = None
        self.api.add_pin(tube, MIDDLE, name="Pin")
        tube.vertex_groups.remove(tube.vertex_groups["Pin"])
        other.vertex_groups.remove(other.vertex_groups["Head"])
        bpy.ops.wm.save_as_mainfile(filepath=str(self.input))
        reasons = (
            "Handle 'Head' of 'Other': there is no vertex group 'Head'; choose one or remove the handle. "
            "Handle 'Belt' of 'Tube': it has no object; choose one or remove the handle. "
            "Pin 'Pin' of 'Tube': there is no vertex group 'Pin'; choose one or remove the pin"
        )
        for arguments in (("pose",), ("bake",), ("bake", "--frame", 1)):
            self.assert_failed(reasons, *arguments, self.input, "-o", self.output)
            self.assertEqual(module("core.sessions").locks, {})
        self.assertEqual(list(self.folder.glob(".*")), [])
        self.assertFalse(self.output.exists())

    def test_what_breaks_in_a_later_frame_is_told_before_any_is_solved(self):
        posable("Other")
        self.save_scene()
        target = bpy.data.objects["Other"].arap.handles[0].target
        for target.hide_viewport, frame in ((False, 1), (True, 11)):
            target.keyframe_insert("hide_viewport", frame=frame)
        bpy.ops.wm.save_as_mainfile(filepath=str(self.input))
        code, out, err = self.run_cli("bake", self.input, "-o", self.output)
        self.assertEqual((code, out), (1, ""))
        self.assertRegex(err, r"^arap: Handle 'Head' of 'Other': 'Head.*' is disabled in viewports .*\n$")

    def test_all_objects_are_baked_in_one_walk_over_the_frames(self):
        """Each change of frame evaluates the whole scene."""
        frames, walks = [], []

        def count(scene, *_):
            frames.append(scene.frame_current)

        bpy.app.handlers.persistent(count)
        bpy.app.handlers.frame_change_post.append(count)
        self.addCleanup(bpy.app.handlers.frame_change_post.remove, count)
        for others in ((), ("Other", "Third")):
            self.setUp()
            for name in others:
                animate(posable(name))
            self.save_scene()
            frames.clear()
            out, _ = self.done("bake", self.input)
            self.assertEqual(out.count("11 keys"), 1 + len(others))
            walks.append(frames.copy())
        self.assertEqual(walks[0], walks[1])

    def test_a_mesh_that_hangs_on_another_one_is_posed_after_it(self):
        """Its handle hangs on a vertex of the other; both are in one command."""
        for command in (["pose", "--frame", 11], ["bake", "--frame", 11], ["bake", "--start", 1, "--end", 11]):
            with self.subTest(command=command):
                bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
                worn = mesh_object("Above", Matrix.Translation((0.0, 0.0, 4.0)))
                self.api.add_pin(worn, TOP)
                self.scene = bpy.context.scene
                self.save_scene()
                rider = empty_at((0.0, 0.0, 0.0), "Rider")
                rider.parent, rider.parent_type = bpy.data.objects["Tube"], "VERTEX"
                rider.parent_vertices = (TOP[0], 0, 0)
                bpy.context.view_layer.update()
                self.api.add_handle_for(worn, rider, "", 0.6)
                self.assertEqual(len(module("scene.movers.order").waves([worn, bpy.data.objects["Tube"]])), 2)
                bpy.ops.wm.save_as_mainfile(filepath=str(self.input))
                out, _ = self.done(*command, self.input, "--overwrite")
                self.assertLess(out.index("Tube:"), out.index("Above:"))
                bpy.context.scene.frame_set(11)
                self.assertGreater(np.abs(shown_positions(bpy.data.objects["Above"])[BOTTOM, 1]).max(), 0.9)

    def test_a_folder_that_cannot_be_written_is_told_before_any_work(self):
        self.save_scene()
        self.load(self.input)
        with unittest.mock.patch.object(Path, "open", side_effect=PermissionError(13, "Permission denied")):
            message = f"{self.output} cannot be written (Permission denied): choose another folder or another name"
            self.assert_failed(message, "bake", self.input, "-o", self.output)

    def test_a_full_disk_is_told_and_leaves_nothing(self):
        self.save_scene()
        disk = types.SimpleNamespace(free=1000)
        reason = r"takes 18 kB, 17 kB more than \S+ has free: free disk space there, or choose another folder"
        with unittest.mock.patch.object(shutil, "disk_usage", return_value=disk):
            for option, name in (("-o", "output.blend"), ("--cache", "tube.mdd")):
                bpy.ops.wm.open_mainfile(filepath=str(self.input))
                bpy.ops.wm.save_as_mainfile(filepath=str(self.input), compress=False)
                files = set(self.folder.iterdir())
                outputs = ("-o", self.output, option, self.folder / name)
                code, out, err = self.run_cli("bake", self.input, *outputs)
                self.assertEqual((code, out), (1, ""))
                self.assertRegex(err, rf"^arap: \S+{name} {reason}\n$")
                self.assertEqual(set(self.folder.iterdir()), files)
        before = self.input.read_bytes()
        with self.failing_save():
            code, _, err = self.run_cli("bake", self.input, "-o", self.input, "--overwrite")
        self.assertEqual(code, 1)
        reason = r"\(No space left on device\): free disk space, or choose another folder"
        self.assertRegex(err, rf"^arap: \S+input.blend could not be written {reason}\n$")
        self.assertEqual(self.input.read_bytes(), before)
        self.assertEqual(set(self.folder.iterdir()), files)

    def failing_save(self):
        error = RuntimeError("Error: No space left on device\n")
        return unittest.mock.patch.object(module("cli"), "_write_blend", side_effect=error)

    def test_two_processes_that_write_one_file(self):
        """Whatever the other one does meanwhile, the file is whole, and of the one that ends last."""
        self.save_scene()
        write = module("cli")._write_blend

        def write_after_another(path):
            done = self.blender(["pose", str(self.input), "--frame", "11", "-o", str(self.output)])
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertTrue(self.output.is_file())
            write(path)

        with unittest.mock.patch.object(module("cli"), "_write_blend", write_after_another):
            _, obj = self.done("bake", self.input)
        self.assertIn("ARAP_0011", key_names(obj))
        self.assertNotIn("ARAP", key_names(obj))
        others = self.folder / "output.blend1"  # as Blender keeps what it saves over
        self.assertEqual(sorted(self.folder.iterdir()), [self.input, self.output, others])

    def test_a_library_of_the_file_is_not_written_over(self):
        library = self.folder / "library.blend"
        bpy.data.libraries.write(str(library), {bpy.data.objects.new("Linked", None)})
        with bpy.data.libraries.load(str(library), link=True) as (_, data):
            data.objects = ["Linked"]
        self.scene.collection.objects.link(bpy.data.objects["Linked", str(library)])
        self.save_scene()
        before = library.read_bytes()
        message = f"{library} is a library of the file: give another file with -o"
        code, _, err = self.run_cli("bake", self.input, "-o", library, "--overwrite")
        self.assertEqual((code, err), (1, f"arap: {message}\n"))
        self.assertEqual(library.read_bytes(), before)

    def test_a_scene_without_handles_fails(self):
        mesh_object()
        bpy.ops.wm.save_as_mainfile(filepath=str(self.input))
        message = "No mesh in scene 'Scene' has handles: add some in Blender first"
        self.assert_failed(message, "pose", self.input, "-o", self.output)

    def test_internal_errors_give_one_line_too(self):
        self.save_scene()
        with unittest.mock.patch.object(module("cli"), "begin_solve", side_effect=KeyError("x")):
            message = "internal error, please report it: KeyError: 'x'"
            self.assert_failed(message, "pose", self.input, "-o", self.output)

    def test_a_file_saved_in_any_mode(self):
        modes = ("EDIT", "SCULPT", "WEIGHT_PAINT", "VERTEX_PAINT", "TEXTURE_PAINT")
        for mode in modes:
            with self.subTest(mode):
                bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
                self.save_in_mode(posable(), mode)
                self.output.unlink(missing_ok=True)
                out, obj = self.done("bake", self.input, "--start", 1, "--end", 2)
                self.assertTrue(out.startswith("Tube: 2 keys"))
                self.assertEqual(obj.mode, "OBJECT")

    def save_in_mode(self, obj, mode: str) -> None:
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.mode_set(mode=mode)
        bpy.ops.wm.save_as_mainfile(filepath=str(self.input))

    def test_a_rig_saved_in_edit_mode_moves(self):
        rig, obj = armature(), mesh_object()
        self.api.add_pin(obj, BOTTOM)
        self.api.add_handle_for(obj, rig, "Upper", 2.1)
        bone = rig.pose.bones["Upper"]
        for frame in (1, 2):
            bone.location.x = frame - 1.0
            bone.keyframe_insert("location", frame=frame)
        self.scene.frame_set(1)
        self.save_in_mode(rig, "EDIT")
        _, obj = self.done("bake", self.input, "--start", 1, "--end", 2)
        moved = key_positions(obj, "ARAP_0002")[MIDDLE] - rest_positions(obj)[MIDDLE]
        self.assert_close(moved.mean(axis=0), [1.0, 0.0, 0.0], 1e-3)

    def test_a_hidden_mesh_saved_in_edit_mode_while_another_is_active(self):
        posable("Other")
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.mode_set(mode="EDIT")
        obj.hide_set(True)
        bpy.context.view_layer.objects.active = bpy.data.objects["Other"]
        bpy.ops.wm.save_as_mainfile(filepath=str(self.input))
        out, _ = self.done("bake", self.input, "--start", 1, "--end", 1)
        self.assertIn("Tube: 1 key", out)
        self.assertIn("Other: 1 key", out)

    def test_a_library_that_is_gone_is_named(self):
        library = self.folder / "library.blend"
        empty_at((0.0, 0.0, 4.0), "Control")
        posable("Linked")
        bpy.ops.wm.save_as_mainfile(filepath=str(library))
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        with bpy.data.libraries.load(str(library), link=True) as (_, data):
            data.objects = ["Control", "Linked"]
        for obj in data.objects:
            bpy.context.scene.collection.objects.link(obj)
        bpy.ops.wm.save_as_mainfile(filepath=str(self.folder / "none.blend"))
        obj = mesh_object()
        self.api.add_pin(obj, BOTTOM)
        self.api.add_handle_for(obj, bpy.data.objects["Control"], radius=0.7)
        bpy.ops.wm.save_as_mainfile(filepath=str(self.input))
        library.unlink()
        remedy = "bring that file back, or link it again"
        message = f"Handle 'Control' of 'Tube': 'Control' is missing from //library.blend; {remedy}"
        self.assert_named(message, "bake", self.input)
        self.assert_named(message, "pose", self.input)
        self.assert_named(
            f"'Linked' is missing from //library.blend; {remedy}", "bake", self.input, "--object", "Linked"
        )
        message = "No mesh in scene 'Scene' has handles: bring back //library.blend, which is missing"
        self.assert_named(message, "bake", self.folder / "none.blend")
        self.assertFalse(self.output.exists())

    def assert_named(self, reason: str, *arguments) -> None:
        """As assert_failed(), where Blender prints lines of its own when it opens the file."""
        code, _, err = self.run_cli(*arguments, "-o", self.output)
        self.assertEqual((code, err), (1, f"arap: {reason}\n"))

    def test_scripts_that_are_not_allowed(self):
        obj = posable()
        driver = obj.arap.handles[0].target.driver_add("location", 1).driver
        driver.expression = "float(str(frame * 0.1))"
        bpy.ops.wm.save_as_mainfile(filepath=str(self.input))
        message = (
            "Handle 'Head' of 'Tube' does not move as it should: the driver of 'location' of 'Head' needs Python "
            "(float(str(frame * 0.1))), which may not run; allow scripts (--enable-autoexec on the command line)"
        )
        arguments = ("bake", self.input, "--start", 10, "--end", 10)
        self.assert_failed(message, *arguments, "-o", self.output)
        self.assertFalse(self.output.exists())
        _, obj = self.done(*arguments, "--enable-autoexec")
        self.assert_top_has_moved(obj, key_positions(obj, "ARAP_0010"))

    def test_a_pose_that_would_not_be_seen(self):
        self.save_scene()
        obj = bpy.data.objects["Tube"]
        obj.shape_key_add(name="Basis")
        obj.shape_key_add(name="Mine")
        obj.active_shape_key_index, obj.show_only_shape_key = 1, True
        bpy.ops.wm.save_as_mainfile(filepath=str(self.input))
        message = "'Tube' shows another shape key alone: turn off Shape Key Lock (the pin icon)"
        for command in ("bake", "pose"):
            self.assert_failed(message, command, self.input, "-o", self.output)

    def test_in_a_blender_of_its_own(self):
        """As a user types it. bpy from PyPI has no executable, there a Python script stands for it."""
        self.save_scene()
        arguments = ["bake", str(self.input), "--end", "3", "-o", str(self.output)]
        for wanted_code, extra in ((0, []), (1, []), (2, ["--fast"])):  # the second time the output exists
            done = self.blender([*arguments, *extra])
            self.assertEqual(done.returncode, wanted_code, done.stdout + done.stderr)
        self.assertIn("unrecognized arguments: --fast", done.stderr)
        self.assertIn("ARAP_0003", self.load(self.output).data.shape_keys.key_blocks)

    def blender(self, arguments: list[str]) -> subprocess.CompletedProcess[str]:
        if bpy.app.binary_path:
            bpy.ops.wm.save_userpref()  # in the throw-away user folder: there the add-on is enabled
            command = [bpy.app.binary_path, "--command", "arap", *arguments]
        else:
            enable = f"import bpy, sys; bpy.ops.preferences.addon_enable(module={support.PACKAGE!r})"
            call = f"from {support.PACKAGE} import cli; sys.exit(cli.main(sys.argv[1:]))"
            command = [sys.executable, "-c", f"{enable}; {call}", *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False)
