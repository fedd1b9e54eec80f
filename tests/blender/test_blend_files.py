# SPDX-License-Identifier: GPL-3.0-or-later
"""The committed scenes, opened as they are: handles and pins work, poses and bakes come out right."""

from pathlib import Path

import numpy as np
from looks import edge_lengths, key_positions, rest_positions
from support import SceneTest, bpy, module

FILES = Path(__file__).resolve().parents[2] / "blend_files"
POSED = {"bar": ("Bar bend", "Bar twist"), "cactus": ("Cactus",), "creature": ("Creature",), "dressed": ("Child",)}
WORN = {"Shirt": "bend", "Belt": "bend", "Buttons": "rigid", "Eyes": "rigid", "Hair": "bend", "Smile": "bend"}


def hard_vertices(obj, group):
    """Vertices of weight 1 in that group and in no other pin or handle."""
    names = [control.vertex_group for control in obj.arap.controls]
    weights = module("scene.meshes").read_weights(obj, names)
    others = sum(weights[name] for name in names if name != group)
    return np.flatnonzero((weights[group] == 1.0) & (others == 0.0))


class BlendFileTest(SceneTest):
    def open(self, name):
        bpy.ops.wm.open_mainfile(filepath=str(FILES / f"{name}.blend"))
        scene = bpy.context.scene
        posed = [obj for obj in scene.objects if obj.type == "MESH" and obj.arap.handles]
        posed.sort(key=lambda obj: obj.name)
        self.assertEqual(tuple(obj.name for obj in posed), POSED[name])
        return scene, posed

    def test_every_file_is_tested(self):
        self.assertEqual({path.stem for path in FILES.glob("*.blend")}, set(POSED))

    def test_the_first_frame_is_at_rest(self):
        for name in POSED:
            scene, posed = self.open(name)
            scene.frame_set(scene.frame_start)
            for obj in posed:
                with self.subTest(obj.name):
                    self.assertIsNone(obj.data.shape_keys, "a scene comes without a pose")
                    self.assertEqual(self.api.solve(obj).stop_reason, "converged")
                    size = np.ptp(rest_positions(obj), axis=0).max()
                    self.assert_close(key_positions(obj), rest_positions(obj), 1e-5 * size)

    def test_the_last_frame_is_posed(self):
        for name in POSED:
            scene, posed = self.open(name)
            scene.frame_set(scene.frame_end)
            for obj in posed:
                with self.subTest(obj.name):
                    self.assertEqual(self.api.solve(obj).parts_at_rest, 0)
                    self.check_pose(obj)

    def test_what_is_worn_goes_along(self):
        scene, (child,) = self.open("dressed")
        attachments = child.arap.attachments
        self.assertEqual({attachment.object.name: attachment.kind for attachment in attachments}, WORN)
        scene.frame_set(scene.frame_end)
        self.api.solve(child)
        for obj in (attachment.object for attachment in attachments):
            with self.subTest(obj.name):
                self.assertGreater(np.abs(key_positions(obj) - rest_positions(obj)).max(), 0.01)

    def check_pose(self, obj):
        rest, posed = rest_positions(obj), key_positions(obj)
        size = np.ptp(rest, axis=0).max()
        for pin in obj.arap.pins:
            held = hard_vertices(obj, pin.vertex_group)
            self.assertGreater(len(held), 0)
            self.assert_close(posed[held], rest[held], 1e-5 * size)
        motions = module("scene.handle_motion").handle_matrices(obj)
        moving = ((c, motion) for c, motion in zip(obj.arap.controls, motions, strict=True) if not c.is_pin)
        for handle, motion in moving:
            moved = hard_vertices(obj, handle.vertex_group)
            self.assertGreater(len(moved), 0)
            self.assertGreater(np.abs(motion - np.eye(4)).max(), 0.01, "the last frame moves every handle")
            self.assert_close(posed[moved], rest[moved] @ motion[:3, :3].T + motion[:3, 3], 1e-5 * size)
        stretch = edge_lengths(obj, posed) / edge_lengths(obj, rest)
        self.assertLess(abs(np.median(stretch) - 1.0), 0.02, "as rigid as possible: most edges keep their length")

    def test_a_bake_shows_the_poses(self):
        for name in POSED:
            scene, posed = self.open(name)
            obj = posed[0]
            frames = (scene.frame_start, scene.frame_end)
            names = self.api.bake_animation(obj, *frames, step=frames[1] - frames[0])
            self.assertEqual(names, [f"ARAP_{frame:04d}" for frame in frames])
            with self.subTest(obj.name):
                scene.frame_set(frames[1])
                keys = obj.data.shape_keys.key_blocks
                self.assertEqual([round(keys[key].value, 6) for key in names], [0.0, 1.0])
                moved = np.abs(key_positions(obj, names[1]) - rest_positions(obj)).max()
                self.assertGreater(moved, 0.1 * np.ptp(rest_positions(obj), axis=0).max())
