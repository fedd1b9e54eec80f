# SPDX-License-Identifier: GPL-3.0-or-later
"""Data of ours that is damaged or hostile, names that Blender would cut in a character, and the monkey."""

import base64
import contextlib
import io
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from unittest import mock

import hostile
import numpy as np
from looks import key_names, key_positions, rest_positions
from support import ZIP, SceneTest, bpy, module
from tubes import bend, move, posable, solved

MONKEY = Path(__file__).resolve().parents[1] / "attack" / "monkey.py"
LONG_NAMES = ["Ü" * 40, "名" * 30, "a" * 62 + "Ü"]


class HostileTest(SceneTest):
    def test_long_names_are_cut_between_characters(self):
        obj = solved()
        for name in LONG_NAMES:
            with self.subTest(name=name):
                cut = name.encode()[:63].decode(errors="ignore")
                self.assertEqual(self.api.bake_pose(obj, name=name).name, cut)
                self.assertEqual(self.api.store_pose(obj, name).name, cut)
        self.assertEqual(len(key_names(obj)), 2 + len(LONG_NAMES))

    def test_damaged_pull_pins_hold_nothing_and_go(self):
        obj = posable()
        pins = module("pull.pins")
        n = len(obj.data.vertices)
        texts = ["???", base64.b64encode(b"12345").decode(), *(
            base64.b64encode(np.array(v, "<i4").tobytes()).decode() for v in ([-1, 2], [3, n], [5, 4], [])
        )]  # fmt: skip
        for text in texts:
            pin = obj.arap.pull_pins.add()
            pin.vertices_text, pin.n_vertices = text, n
            self.assertEqual(len(pin.vertices), 0, text)
        self.assertEqual(pins.find(obj, np.arange(n)), [])
        pins.forget_stale(obj)
        self.assertEqual(len(obj.arap.pull_pins), 0)

    def test_a_stored_motion_that_is_not_finite_moves_nothing(self):
        obj = posable()
        pose = self.api.store_pose(obj, "Broken")
        pose.motions[0].motion = [float("nan")] * 16
        before = obj.arap.handles[0].target.matrix_world.copy()
        message = "The stored motion of handle 'Head' is damaged: store the pose again"
        self.assert_error(ValueError, message, self.api.apply_pose, obj, "Broken")
        self.assertEqual(obj.arap.handles[0].target.matrix_world, before)

    def test_a_rest_place_that_is_not_finite_is_named(self):
        obj = posable()
        obj.arap.handles[0].rest_matrix = [1e38] * 16
        message = "Handle 'Head' of 'Tube': its rest place is not a finite one; choose 'Head' again"
        self.assert_error(ValueError, message, self.api.solve, obj)

    def test_a_geometry_nodes_modifier_without_a_group_is_no_user_of_vertex_groups(self):
        obj = posable()
        obj.modifiers.new("Empty", "NODES").node_group = None
        self.api.remove_control(obj, obj.arap.pins[0].name)
        self.assertNotIn("Feet", obj.vertex_groups)

    def test_a_name_that_is_none_is_refused(self):
        obj = posable()
        with self.assertRaisesRegex(ValueError, "is no name: give that of the pin, handle or bone"):
            self.api.remove_control(obj, obj.arap.handles[0])

    def test_polls_answer_without_a_window(self):
        posable()
        checks = module("ui.checks")
        bare = mock.Mock(spec=["view_layer"], view_layer=bpy.context.view_layer)
        self.assertEqual(checks.why_no_mesh(bare), "Select a mesh first")

    def test_a_bake_of_all_frames_there_are_is_estimated_at_once(self):
        estimate = module("bake.estimate")
        last = estimate.LAST_FRAME
        self.assertEqual(estimate.n_frames(-last, last, 1), 2 * last + 1)
        for frames in ((1, 10, 1), (1, 10, 3), (1, 10, 4), (5, 5, 2)):
            self.assertEqual(estimate.n_frames(*frames), len(estimate.frames_of(*frames)), frames)

    def test_the_command_line_runs_no_scripts_of_the_file(self):
        cli = module("cli")
        obj = posable()
        bend(obj)
        path = Path(bpy.app.tempdir) / "stranger.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
        opened = []
        operators = mock.Mock(wraps=bpy.ops)
        operators.wm.open_mainfile = lambda **keywords: opened.append(keywords["use_scripts"])
        with mock.patch.object(cli.bpy, "ops", operators):
            for options in ([], ["--enable-autoexec"]):
                cli.main(["pose", str(path), "-o", str(path), "--overwrite", *options])
        self.assertEqual(opened, [False, True])

    def opened(self, make_hostile):
        """The mesh of a hostile file that was just opened. The add-on sleeps while the file is made."""
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        obj = solved()
        rest = rest_positions(obj)
        with mock.patch.object(module("follow.runs"), "_begin"):
            obj.arap.use_follow = True
            make_hostile(obj)
            with tempfile.TemporaryDirectory() as folder:
                path = str(Path(folder) / "hostile.blend")
                bpy.ops.wm.save_as_mainfile(filepath=path)
                with mock.patch.object(module("follow.runs"), "_begin", self._begin):
                    bpy.ops.wm.open_mainfile(filepath=path)
        return next(obj for obj in bpy.data.objects if obj.type == "MESH"), rest

    def test_a_hostile_file_is_opened_at_once_and_hurts_nobody(self):
        self._begin = module("follow.runs")._begin
        sessions = module("core.sessions")
        self.addCleanup(
            setattr, module("follow.scene"), "SCRIPT_TIME_LIMIT_S", module("follow.scene").SCRIPT_TIME_LIMIT_S
        )
        module("follow.scene").SCRIPT_TIME_LIMIT_S = 0.5
        for make_hostile in hostile.KINDS:
            with self.subTest(kind=make_hostile.__name__):
                said = io.StringIO()
                with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
                    obj, rest = self.opened(make_hostile)
                    self.assertIsNone(sessions.get(obj.session_uid), "nothing is bound")
                    self.assertEqual((key_names(obj), bpy.data.is_dirty), (["Basis", "ARAP"], self.new_is_dirty))
                    move(bpy.data.objects["Head"], (0.0, 0.0, 0.1))
                    bpy.context.scene.frame_set(2)
                    pose = next((pose.name for pose in obj.arap.poses), "none")
                    for act, *arguments in (
                        (self.api.solve,),
                        (self.api.apply_pose, pose),
                        (self.api.reset_handles,),
                        (self.api.remove_control, "Head"),
                    ):
                        with contextlib.suppress(ValueError, RuntimeError):
                            act(obj, *arguments)
                self.assertNotIn("Traceback", said.getvalue())
                self.assertLessEqual(said.getvalue().count("Follow is off"), 1, "it is told once")
                for name in key_names(obj):
                    self.assertTrue(np.isfinite(key_positions(obj, name)).all(), name)
                self.assert_close(rest_positions(obj), rest, 0.0)

    def test_a_monkey_finds_nothing(self):
        command = [sys.executable, str(MONKEY), "--", str(ZIP), "--acts", "120"]
        if bpy.app.binary_path:
            command = [bpy.app.binary_path, "-b", "--factory-startup", "--python", str(MONKEY), *command[2:]]
        env = {name: value for name, value in os.environ.items() if name != "ARAP_TEST_USER_FOLDER"}
        run = subprocess.run(command, capture_output=True, text=True, check=False, env=env)
        self.assertIn("120 acts, 0 failed", run.stdout, run.stdout[-3000:] + run.stderr[-3000:])
