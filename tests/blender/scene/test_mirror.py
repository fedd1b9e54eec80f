# SPDX-License-Identifier: GPL-3.0-or-later
"""Half a mesh with a Mirror modifier is posed as the whole, in every way."""

import numpy as np
from looks import key_positions, rest_positions, unfit
from mathutils import Matrix
from support import SceneTest, bpy, module
from tubes import PLACED, empty_at, move, posable

RINGS, SEGMENTS, LENGTH = 21, 16, 4.0


def half_tube(matrix: Matrix | None = None, share: float = 0.5) -> bpy.types.Object:
    """The half of an open tube with x >= 0 (or a smaller share), pinned below, with a Mirror modifier for x."""
    n = round(SEGMENTS * share) + 1
    angle = np.linspace(-np.pi / 2.0, -np.pi / 2.0 + 2.0 * np.pi * share, n)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(n)]) * 0.5
    ring[np.abs(ring) < 1e-9] = 0.0
    height = np.linspace(0.0, LENGTH, RINGS)
    positions = (ring[None] + height[:, None, None] * np.array([0.0, 0.0, 1.0])).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(RINGS - 1), np.arange(n - 1), indexing="ij")
    quads = np.stack([i * n + j, i * n + j + 1, (i + 1) * n + j + 1, (i + 1) * n + j], -1).reshape(-1, 4)
    mesh = bpy.data.meshes.new("Half")
    mesh.from_pydata(positions.tolist(), [], quads.tolist())
    obj = bpy.data.objects.new("Half", mesh)
    bpy.context.scene.collection.objects.link(obj)
    obj.matrix_world = matrix or Matrix()
    obj.modifiers.new("Mirror", "MIRROR")
    bpy.context.view_layer.update()
    module("api").add_pin(obj, range(n), name="Feet")
    obj.arap.accuracy, obj.arap.max_iterations, obj.arap.rigidity = 1e-7, 5000, 6.0
    return obj


def top(obj: bpy.types.Object) -> list[int]:
    return np.flatnonzero(rest_positions(obj)[:, 2] > LENGTH - 1e-6).tolist()


def side(obj: bpy.types.Object) -> int:
    """The vertex half way up and farthest from the plane."""
    return int(np.linalg.norm(rest_positions(obj) - (0.5, 0.0, LENGTH / 2.0), axis=1).argmin())


def vertices_seen(obj: bpy.types.Object) -> int:
    bpy.context.view_layer.update()
    return len(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices)


class MirrorTest(SceneTest):
    def assert_on_plane(self, obj: bpy.types.Object, positions: np.ndarray, axis: int = 0) -> None:
        is_on = np.abs(rest_positions(obj)[:, axis]) < 1e-6
        self.assertGreaterEqual(is_on.sum(), RINGS)
        self.assert_close(positions[is_on, axis], 0.0, 1e-6)
        self.assertGreater(np.abs(positions - rest_positions(obj))[is_on].max(), 0.05)

    def bent(self, matrix: Matrix | None = None) -> bpy.types.Object:
        obj = half_tube(matrix)
        self.api.add_handle(obj, top(obj), name="Top")
        self.api.add_handle(obj, [side(obj)], name="Side")
        move(obj.arap.handles[0].target, (0.0, 0.5, 0.2))
        move(obj.arap.handles[1].target, (0.3, 0.1, 0.1))
        return obj

    def test_solved_posed_and_baked(self):
        for matrix in (Matrix(), PLACED):
            with self.subTest(matrix=matrix):
                obj = self.bent(matrix)
                n = vertices_seen(obj)
                self.api.solve(obj)
                self.assert_on_plane(obj, key_positions(obj))
                self.assertEqual(vertices_seen(obj), n, "the halves are merged as at rest")
                names = self.api.bake_animation(obj, 1, 2)
                for name in names:
                    self.assert_on_plane(obj, key_positions(obj, name))

    def test_follow_keeps_it_too(self):
        obj = self.bent()
        obj.arap.use_follow = True
        move(obj.arap.handles[0].target, (0.4, 0.2, 0.0))
        self.assertEqual(obj.arap.follow_error, "")
        self.assert_on_plane(obj, key_positions(obj))

    def test_a_pull_keeps_it_too(self):
        obj = half_tube()
        on_plane = int(np.linalg.norm(rest_positions(obj) - (0.0, -0.5, LENGTH / 2.0), axis=1).argmin())
        grab = module("pull.region").PulledPatch(np.array([on_plane], np.int32), 1.0)
        begun = module("pull.hold").begin_pull(obj, bpy.context.evaluated_depsgraph_get(), [grab])
        session = module("core.background").run(module("core.sessions").build(begun.inputs))
        module("engine.mesh").adopt(obj, begun.inputs, session)
        motion = np.eye(4)
        motion[:3, 3] = (0.3, -0.3, 0.0)
        bound = module("core.sessions").get(obj.session_uid)
        frame = module("engine.frame")
        snapshot, _ = frame.look(obj, bpy.context.evaluated_depsgraph_get(), bound, begun.holds)
        matrices = begun.matrices(motion, np.eye(4))
        frame.solve(snapshot, bound, matrices, initial_guess="previous", to_convergence=True)
        bpy.context.view_layer.update()
        self.assert_on_plane(obj, key_positions(obj))

    def test_a_mirror_object_and_two_axes(self):
        obj = half_tube(share=0.25)
        modifier = obj.modifiers["Mirror"]
        modifier.use_axis = (True, True, False)
        modifier.mirror_object = empty_at((0.0, 0.0, 1.0))
        bpy.context.view_layer.update()
        n = vertices_seen(obj)
        self.api.add_handle(obj, [int(np.linalg.norm(rest_positions(obj) - (0.35, -0.35, 2.0), axis=1).argmin())])
        move(obj.arap.handles[0].target, (0.4, -0.2, 0.2))
        self.api.solve(obj)
        for axis in (0, 1):
            self.assert_on_plane(obj, key_positions(obj), axis)
        self.assertEqual(vertices_seen(obj), n)

    def test_what_is_added_to_a_posed_half_leaves_it_in_place(self):
        for vertices in ("top", "plane", "beside"):
            with self.subTest(vertices):
                obj = self.bent()
                self.api.solve(obj)
                posed = key_positions(obj)
                rest = rest_positions(obj)
                added = {
                    "top": np.flatnonzero(np.abs(rest[:, 2] - 3.0) < 0.15),
                    "plane": [int(np.linalg.norm(rest - (0.0, 0.5, 1.4), axis=1).argmin())],
                    "beside": [int(np.linalg.norm(rest - (0.5, 0.0, 2.2), axis=1).argmin())],
                }[vertices]
                self.api.add_handle(obj, added)
                bpy.context.view_layer.update()
                self.api.solve(obj)
                self.assert_close(key_positions(obj), posed, 4e-4)

    def test_a_plane_that_completes_nothing_may_move(self):
        """A tube that is mirrored to the other side of a body: its session goes on where the tube moves alone."""
        obj = posable()
        modifier = obj.modifiers.new("Mirror", "MIRROR")
        modifier.mirror_object = empty_at((3.0, 0.0, 0.0))
        session = module("engine.update").prepare_session(obj)
        for place in ((1.0, 0.0, 0.0), (2.0, 1.0, 0.0)):
            obj.location = place
            bpy.context.view_layer.update()
            self.assertEqual(unfit(obj), "")
        self.assertIs(module("engine.update").prepare_session(obj), session)

    def test_a_half_goes_on_where_it_moves_far_from_the_origin(self):
        obj = self.bent()
        root, centre = empty_at((0.0, 0.0, 0.0)), empty_at((0.0, 3.0, 7.0))
        centre.rotation_euler.x = 0.7  # another matrix, with the same plane
        obj.parent = centre.parent = root
        obj.modifiers["Mirror"].mirror_object = centre
        root.location = (23456.7, -9876.5, 0.0)
        bpy.context.view_layer.update()
        module("engine.update").prepare_session(obj)
        for turn in (0.3, 1.1, 2.2):
            root.rotation_euler = (0.1, turn, -turn)
            bpy.context.view_layer.update()
            self.assertEqual(unfit(obj), "")

    def test_a_bake_sees_an_animated_plane(self):
        """Where the plane is away, the half is posed alone; where it is back, as the whole."""
        obj = self.bent()
        modifier = obj.modifiers["Mirror"]
        for key, is_on in ((1, True), (2, False), (3, True)):
            modifier.show_viewport = modifier.show_render = is_on
            modifier.keyframe_insert("show_viewport", frame=key)
            modifier.keyframe_insert("show_render", frame=key)
        self.scene.frame_set(1)
        names = self.api.bake_animation(obj, 1, 3)
        is_on_plane = np.abs(rest_positions(obj)[:, 0]) < 1e-6
        far = [np.abs(key_positions(obj, name)[is_on_plane, 0]).max() for name in names]
        self.assertLess(far[0], 1e-6)
        self.assertGreater(far[1], 1e-3)
        self.assertLess(far[2], 1e-6)

    def test_the_modifier_is_heard(self):
        obj = self.bent()
        modifier = obj.modifiers["Mirror"]
        session = module("engine.update").prepare_session(obj)
        whole_size = module("scene.ui_cache").diagonal(obj, bpy.context.evaluated_depsgraph_get())
        self.assertAlmostEqual(whole_size, np.linalg.norm([1.0, 1.0, LENGTH]), places=5)
        for change, back in (
            (("merge_threshold", 0.002), 0.001),
            (("use_axis", (False, True, False)), (True, False, False)),
            (("use_bisect_axis", (True, False, False)), (False, False, False)),
        ):
            setattr(modifier, *change)
            bpy.context.view_layer.update()
            self.assertEqual(unfit(obj), "The Mirror modifier of 'Half' has changed", change)
            setattr(modifier, change[0], back)
        for modifier.show_viewport, modifier.show_render, fits in (
            (False, True, True),  # off where the artist works, as it is slow, and on in the final render
            (True, False, True),
            (False, False, False),
        ):
            bpy.context.view_layer.update()
            self.assertEqual(unfit(obj) == "", fits)
        modifier.show_viewport = modifier.show_render = True
        modifier.use_mirror_merge = False
        modifier.use_clip = True
        self.assertIs(module("engine.update").prepare_session(obj), session)
        modifier.use_clip = False
        self.assertIsNot(module("engine.update").prepare_session(obj), session)
        self.api.solve(obj)
        is_on = np.abs(rest_positions(obj)[:, 0]) < 1e-6
        self.assertGreater(np.abs(key_positions(obj)[is_on, 0]).max(), 1e-3, "without both the halves are apart")
