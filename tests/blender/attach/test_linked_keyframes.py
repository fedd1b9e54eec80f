# SPDX-License-Identifier: GPL-3.0-or-later
"""Attach: the keyframes of linked_keys, which exporters take."""

import json

from clothes import AttachTest, eye, sleeve
from looks import key_names
from support import bpy, module
from tubes import animate, bend, own_key, posable, solved


class TwinKeyframesTest(AttachTest):
    def setUp(self):
        super().setUp()
        self.fcurves = module("scene.fcurves")

    def dressed(self):
        host, target = solved(), sleeve()
        self.api.attach(host, [target])
        return host, target

    def animations(self, *objs):
        """Of a glTF file with the exporter's own settings: for each the names of what it animates."""
        for obj in bpy.data.objects:
            obj.select_set(obj in objs)
        path = self.new_folder() / "figure.gltf"
        bpy.ops.export_scene.gltf(filepath=str(path), export_format="GLTF_SEPARATE", use_selection=True)
        file = json.loads(path.read_text())
        nodes = file["nodes"]
        return [
            {nodes[channel["target"]["node"]]["name"] for channel in animation["channels"]}
            for animation in file.get("animations", [])
        ]

    def keyframes(self, obj, name):
        path = f'key_blocks["{name}"].value'
        in_action = self.fcurves.fcurves_of(obj.data.shape_keys)
        fcurve = in_action.find(path) if in_action is not None else None
        return None if fcurve is None else [(*point.co, point.interpolation) for point in fcurve.keyframe_points]

    def key(self, host, name, *frames):
        key = host.data.shape_keys.key_blocks[name]
        for frame in frames:
            key.value = frame / 10.0
            key.keyframe_insert("value", frame=frame)
        bpy.context.view_layer.update()

    def test_a_body_and_its_clothes_are_one_animation(self):
        host, shirt, buckle = posable(), sleeve(), eye()
        animate(host)
        self.api.attach(host, [shirt])
        self.api.attach(shirt, [buckle])
        for _ in range(2):
            names = self.api.bake_animation(host, 1, 5)
            self.assertEqual(self.animations(host, shirt, buckle), [{"Tube", "Sleeve", "Eye"}])
            for obj in (shirt, buckle):
                self.assertEqual([self.keyframes(obj, n) for n in names], [self.keyframes(host, n) for n in names])
                self.assertFalse(self.fcurves.is_action_shared(obj.data.shape_keys))

    def test_a_slider_that_is_keyed_later(self):
        """It reaches the clothes, and goes when its keyframes go."""
        host, target = self.dressed()
        self.api.bake_pose(host, "Wave")
        self.assertEqual(self.animations(host, target), [])
        self.key(host, "Wave", 1, 5)
        self.assertEqual(self.animations(host, target), [{"Tube", "Sleeve"}])
        keys = host.data.shape_keys
        points = self.fcurves.fcurves_of(keys)[0].keyframe_points
        points[0].interpolation = "CONSTANT"
        points[1].co.x = 7.0
        bpy.context.view_layer.update()
        self.assertEqual(self.keyframes(target, "Wave"), self.keyframes(host, "Wave"))
        self.assertEqual(self.keyframes(target, "Wave")[1][0], 7.0)
        self.fcurves.fcurves_of(keys).remove(self.fcurves.fcurves_of(keys)[0])
        keys.animation_data.action.update_tag()
        bpy.context.view_layer.update()
        self.assertIsNone(self.keyframes(target, "Wave"))

    def test_between_keyframes_they_are_the_same(self):
        """The handles of keyframes are worked out by what the F-curve is set to."""
        host, target = self.dressed()
        self.api.bake_pose(host, "Wave")
        self.key(host, "Wave", 1, 5, 8, 2)
        (curve,) = self.fcurves.fcurves_of(host.data.shape_keys)
        for curve.auto_smoothing in ("NONE", "CONT_ACCEL"):
            curve.update()
            host.data.shape_keys.animation_data.action.update_tag()
            bpy.context.view_layer.update()
            (linked,) = self.fcurves.fcurves_of(target.data.shape_keys)
            times = [0.25 * i for i in range(40)]
            self.assertEqual([linked.evaluate(t) for t in times], [curve.evaluate(t) for t in times])

    def test_keyframes_that_are_pushed_into_a_strip_stay(self):
        host, target = self.dressed()
        self.key(host, "ARAP", 1, 5)
        expected = self.keyframes(target, "ARAP")
        animation = host.data.shape_keys.animation_data
        action, slot = animation.action, getattr(animation, "action_slot", None)
        strip = animation.nla_tracks.new().strips.new("Bake", 1, action)
        if slot is not None:
            strip.action_slot = slot
        animation.action = None
        bend(host)
        bpy.context.view_layer.update()
        self.assertEqual(self.keyframes(target, "ARAP"), expected)

    def test_an_action_of_the_artists_own_stays(self):
        host, target = self.dressed()
        own_key(target, "Puff", value=0.5).keyframe_insert("value", frame=3)
        action = target.data.shape_keys.animation_data.action
        self.key(host, "ARAP", 1, 5)
        self.assertEqual(target.data.shape_keys.animation_data.action, action)
        self.assertEqual(self.keyframes(target, "Puff"), [(3.0, 0.5, "BEZIER")])
        self.assertEqual(self.keyframes(target, "ARAP"), self.keyframes(host, "ARAP"))

    def test_twins_with_an_action_of_their_own_join_the_bodys(self):
        """As those of older files."""
        host, target = self.dressed()
        target.data.shape_keys.key_blocks["ARAP"].keyframe_insert("value", frame=3)
        former = target.data.shape_keys.animation_data.action.name
        self.key(host, "ARAP", 1, 5)
        self.assertEqual(self.keyframes(target, "ARAP"), self.keyframes(host, "ARAP"))
        self.assertEqual(self.animations(host, target), [{"Tube", "Sleeve"}])
        if hasattr(bpy.types.AnimData, "action_slot"):
            self.assertNotIn(former, bpy.data.actions)

    def test_what_follows_no_more_leaves_nothing(self):
        host, target = self.dressed()
        own_key(target, "Puff", value=0.5)
        self.key(host, "ARAP", 1, 5)
        keyframes, action = self.keyframes(host, "ARAP"), host.data.shape_keys.animation_data.action
        self.api.detach(host, target)
        self.assertEqual(key_names(target), ["Basis", "Puff"])
        self.assertIsNone(target.data.shape_keys.animation_data.action)
        self.assertEqual(self.keyframes(host, "ARAP"), keyframes)
        self.assertEqual(len(getattr(action, "slots", (None,))), 1)
