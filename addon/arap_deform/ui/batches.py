# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays -> batches of Blender's gpu module, how each kind is drawn, and the colours of the user's theme for it."""

from __future__ import annotations

from typing import Any

import bpy
import gpu
import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from ..core.arrays import Float32s, Floats
from ..scene import versions

Color = tuple[float, float, float, float]
NEARER = 1e-3  # fraction of the distance: keeps points on the surface from sinking into it


def index_buffer(triangles: NDArray[np.int32]) -> gpu.types.GPUIndexBuf:
    return gpu.types.GPUIndexBuf(type="TRIS", seq=triangles)


def surface_batch(positions: Float32s, colors: Float32s, indices: gpu.types.GPUIndexBuf) -> gpu.types.GPUBatch:
    """Triangles with a colour at each vertex, for draw_surface()."""
    return gpu.types.GPUBatch(type="TRIS", buf=_vertices(pos=positions, color=colors), elem=indices)


def plain_batch(kind: str, positions: Float32s) -> gpu.types.GPUBatch:
    """POINTS, LINES, LINE_STRIP or TRIS of one colour."""
    return gpu.types.GPUBatch(type=kind, buf=_vertices(pos=positions))


def _vertices(**attributes: Float32s) -> gpu.types.GPUVertBuf:
    form = gpu.types.GPUVertFormat()
    for name, values in attributes.items():
        form.attr_add(id=name, comp_type="F32", len=values.shape[1], fetch_mode="FLOAT")
    result = gpu.types.GPUVertBuf(format=form, len=len(attributes["pos"]))
    for name, values in attributes.items():
        result.attr_fill(name, values)
    return result


def draw_surface(batch: gpu.types.GPUBatch, matrix: Matrix) -> None:
    with _On(matrix, is_hidden_behind=True):
        batch.draw(gpu.shader.from_builtin("SMOOTH_COLOR"))


def draw_points(
    batch: gpu.types.GPUBatch, matrix: Matrix, color: Color, size: float, *, is_hidden_behind: bool
) -> None:
    shader = gpu.shader.from_builtin(versions.POINT_SHADER)
    with _On(matrix, is_hidden_behind=is_hidden_behind):
        gpu.state.point_size_set(size)
        shader.bind()
        shader.uniform_float("color", color)
        batch.draw(shader)
        gpu.state.point_size_set(1.0)


def draw_plain(batch: gpu.types.GPUBatch, matrix: Matrix, color: Color, *, is_hidden_behind: bool) -> None:
    """A plain_batch() of lines, a pixel wide, or of triangles. ``matrix``: of its space."""
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    with _On(matrix, is_hidden_behind=is_hidden_behind):
        shader.bind()
        shader.uniform_float("color", color)
        batch.draw(shader)


def draw_faces(corners: Floats, color: Color, *, is_hidden_behind: bool) -> None:
    """World space: (k, 3) corners of TRIS of one colour."""
    batch = plain_batch("TRIS", np.ascontiguousarray(corners, dtype=np.float32))
    draw_plain(batch, Matrix(), color, is_hidden_behind=is_hidden_behind)


def draw_lines(batch: gpu.types.GPUBatch, color: Color, width: float) -> None:
    """World space, over everything."""
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    with _On(Matrix(), is_hidden_behind=False):
        shader.bind()
        shader.uniform_float("color", color)
        shader.uniform_float("lineWidth", width)
        shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
        batch.draw(shader)


def draw_pixels(kind: str, pixels: Floats, color: Color) -> None:
    """Over the finished picture: (k, 2) corners of TRIS or points of a LINE_STRIP. All must be finite, else nothing."""
    if not len(pixels) or not np.isfinite(pixels).all():
        return
    points = np.zeros((len(pixels), 3), dtype=np.float32)
    points[:, :2] = pixels
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    gpu.state.blend_set("ALPHA")
    shader.bind()
    shader.uniform_float("color", color)
    plain_batch(kind, points).draw(shader)
    gpu.state.blend_set("NONE")


class _On:
    """Sets the state of the gpu module for one drawing, then restores what Blender expects."""

    def __init__(self, matrix: Matrix, *, is_hidden_behind: bool) -> None:
        self._matrix = matrix
        self._is_hidden_behind = is_hidden_behind

    def __enter__(self) -> None:
        gpu.state.blend_set("ALPHA")
        gpu.state.depth_test_set("LESS_EQUAL" if self._is_hidden_behind else "NONE")
        gpu.state.depth_mask_set(False)
        gpu.matrix.push()
        gpu.matrix.load_matrix(_nearer() @ gpu.matrix.get_model_view_matrix() @ self._matrix)

    def __exit__(self, *_: object) -> None:
        gpu.matrix.pop()
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("NONE")


def _nearer() -> Matrix:
    """Moves things a little towards the viewer, without moving them on the screen."""
    view = bpy.context.region_data
    if view.is_perspective:
        return Matrix.Diagonal((1.0 - NEARER, 1.0 - NEARER, 1.0 - NEARER, 1.0))
    return Matrix.Translation((0.0, 0.0, NEARER * view.view_distance))


def color_of_pins() -> Color:
    """As bones in Pose Mode."""
    return _opaque(_theme().view_3d.bone_pose)


def color_of_handles() -> Color:
    """As selected vertices."""
    return _opaque(_theme().view_3d.vertex_select)


def color_of_cubes() -> Color:
    """As lattices, faint: hundreds of lines lie over each other."""
    return (*_opaque(_theme().view_3d.wire_edit)[:3], 0.08)


def color_of_pull() -> Color:
    """As gizmos."""
    return _opaque(_theme().user_interface.gizmo_primary)


def _theme() -> bpy.types.Theme:
    return bpy.context.preferences.themes[0]


def _opaque(color: Any) -> Color:
    return (color[0], color[1], color[2], 1.0)
