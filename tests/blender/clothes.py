# SPDX-License-Identifier: GPL-3.0-or-later
"""A sleeve and an eye of the tube, which go along with it."""

import bmesh
import numpy as np
from looks import in_world, rest_positions, shown_positions
from support import SceneTest, bpy, module
from tubes import SEGMENTS, Matrix, tube_arrays

SLEEVE_RINGS = slice(4, 14)
EYE_PLACE = (0.5, 0.0, 3.4)


def new_object(name, mesh, matrix=None):
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    obj.matrix_world = matrix or Matrix()
    bpy.context.view_layer.update()
    return obj


def sleeve(matrix=None, name="Sleeve"):
    """An open tube a little around the other one."""
    positions, faces = tube_arrays()
    first, last = SLEEVE_RINGS.start * SEGMENTS, SLEEVE_RINGS.stop * SEGMENTS
    kept = [[v - first for v in face] for face in faces[:-2] if min(face) >= first and max(face) < last]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata((positions[first:last] * (1.1, 1.1, 1.0)).tolist(), [], kept)
    return new_object(name, mesh, matrix)


def eye(matrix=None, radius=0.1):
    mesh = bpy.data.meshes.new("Eye")
    ball = bmesh.new()
    bmesh.ops.create_icosphere(ball, subdivisions=2, radius=radius)
    ball.to_mesh(mesh)
    ball.free()
    return new_object("Eye", mesh, (matrix or Matrix()) @ Matrix.Translation(EYE_PLACE))


class AttachTest(SceneTest):
    def carried(self, host, target):
        """(n, 3) where the library takes the attachment for what the host shows."""
        wrap = module("attach.wraps").get(host, module("attach.problems").entry_of(host, target))
        return wrap.carried(np.ascontiguousarray(shown_positions(host), np.float32)).copy()

    def assert_follows(self, host, target):
        shown = shown_positions(target)
        self.assertGreater(np.abs(in_world(target, shown) - in_world(target, rest_positions(target))).max(), 0.1)
        self.assert_close(shown, self.carried(host, target), 2e-5)

    def assert_at_rest(self, target):
        self.assert_close(shown_positions(target), rest_positions(target), 1e-6)

    def problem(self, host, index=0):
        return module("attach.sync").problem_of(host, host.arap.attachments[index])
