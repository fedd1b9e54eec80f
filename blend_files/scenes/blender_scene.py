# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sample scenes share: an empty file, meshes from arrays, materials, studio, keyframes. Runs in Blender."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import cos, pi, radians, sin
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np
from mathutils import Euler, Vector

from .quad_mesh import Floats, Ints, QuadMesh

FPS = 24
LAST_FRAME = 48

VIEW_SHARE = 0.75  # how much nearer the viewport is than the camera

Color = tuple[float, float, float]
Triple = tuple[float, float, float]


class Finish(NamedTuple):
    """A material: linear RGB, or the mesh's colours where None."""

    name: str
    color: Color | None
    roughness: float = 0.6
    specular: float = 0.3


class Move(NamedTuple):
    """Where a handle is at a frame, from rest. Angles are XYZ Euler angles in degrees.

    Attributes:
        frame: the frame.
        turn: around the pivot.
        shift: after that, in metres.
        tilt: around its own place, before both.
    """

    frame: int
    turn: Triple = (0.0, 0.0, 0.0)
    shift: Triple = (0.0, 0.0, 0.0)
    tilt: Triple = (0.0, 0.0, 0.0)


class Lamp(NamedTuple):
    """A disk of light that looks at the subject; ``specular`` scales its mirror image in the eyes."""

    name: str
    place: Triple
    size: float
    watts: float
    color: Color
    specular: float = 1.0


LAMPS = (
    Lamp("Key", (-2.2, -4.5, 3.6), 2.0, 215.0, (1.0, 0.86, 0.70)),
    Lamp("Fill", (4.0, -2.0, 2.2), 3.0, 55.0, (0.70, 0.85, 1.0), specular=0.2),
    Lamp("Rim", (2.0, 3.0, 3.5), 1.5, 100.0, (1.0, 0.90, 0.80), specular=0.5),
)


def empty_file() -> bpy.types.Scene:
    """Removes everything and sets up two seconds of animation."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = FPS
    scene.frame_start, scene.frame_end = 1, LAST_FRAME
    scene.unit_settings.system = "METRIC"
    return scene


def material(finish: Finish) -> bpy.types.Material:
    result = bpy.data.materials.new(finish.name)
    result.use_nodes = True
    shader = result.node_tree.nodes["Principled BSDF"]
    shader.inputs["Roughness"].default_value = finish.roughness
    shader.inputs["Specular IOR Level"].default_value = finish.specular
    result.roughness = finish.roughness
    if finish.color is None:
        colors = result.node_tree.nodes.new("ShaderNodeVertexColor")
        colors.layer_name = "Color"
        colors.location = (-250, 250)
        result.node_tree.links.new(colors.outputs["Color"], shader.inputs["Base Color"])
    else:
        shader.inputs["Base Color"].default_value = (*finish.color, 1.0)
        result.diffuse_color = (*finish.color, 1.0)
    return result


def quads_mesh(name: str, positions: Floats, quads: Ints) -> bpy.types.Mesh:
    """A mesh of (n, 3) positions and (f, 4) quads."""
    data = bpy.data.meshes.new(name)
    data.vertices.add(len(positions))
    data.loops.add(quads.size)
    data.polygons.add(len(quads))
    data.vertices.foreach_set("co", positions.astype(np.float32).ravel())
    data.loops.foreach_set("vertex_index", quads.ravel())
    data.polygons.foreach_set("loop_start", np.arange(0, quads.size, 4, dtype=np.int32))
    data.polygons.foreach_set("loop_total", np.full(len(quads), 4, dtype=np.int32))
    data.update(calc_edges=True)
    return data


def mesh_object(name: str, mesh: QuadMesh, finishes: Sequence[Finish], *, is_smooth: bool = True) -> bpy.types.Object:
    """An object of the mesh; face data "tag" chooses the finish.

    The colour attribute "Color" holds the finishes' colours, and vertex data "color" where a finish has none.
    """
    data = quads_mesh(name, mesh.positions, mesh.quads)
    data.polygons.foreach_set("use_smooth", np.full(len(mesh.quads), is_smooth))
    for finish in finishes:
        data.materials.append(material(finish))
    tags = mesh.face_data.get("tag", np.zeros(len(mesh.quads), dtype=np.int32))
    data.polygons.foreach_set("material_index", tags)
    _set_colors(data, _corner_colors(mesh, tags, finishes))
    data.validate()
    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def _corner_colors(mesh: QuadMesh, tags: Ints, finishes: Sequence[Finish]) -> Floats:
    """(f, 4, 3): by corner, so that an eye ends where its faces end."""
    corners = mesh.vertex_data["color"][mesh.quads] if "color" in mesh.vertex_data else np.ones((len(tags), 4, 3))
    for tag, finish in enumerate(finishes):
        if finish.color is not None:
            corners[tags == tag] = finish.color
    return np.asarray(corners)


def _set_colors(data: bpy.types.Mesh, colors: Floats) -> None:
    layer = data.color_attributes.new("Color", "BYTE_COLOR", "CORNER")
    rgba = np.ones((len(data.loops), 4), dtype=np.float32)
    rgba[:, :3] = np.clip(colors, 0.0, 1.0).reshape(-1, 3)
    layer.data.foreach_set("color", rgba.ravel())
    data.color_attributes.active_color = layer


def studio(
    scene: bpy.types.Scene, backdrop: Color, target: Triple, eye: Triple, *, size: float = 1.0, lens: float = 70.0
) -> None:
    """Ground with a rounded backdrop, warm key light, cool fill, rim light, camera, and the render settings.

    Args:
        scene: the scene.
        backdrop: colour of the ground.
        target: what camera and lights look at.
        eye: the camera's place.
        size: height of what is shown, in units of 1.8 m.
        lens: focal length in mm.
    """
    collection = bpy.data.collections.new("Studio")
    scene.collection.children.link(collection)
    collection.objects.link(_ground(backdrop, target, eye))
    for lamp in LAMPS:
        collection.objects.link(_light(lamp, target, size))
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.75, 0.85, 1.0, 1.0)
    background.inputs["Strength"].default_value = 0.4

    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.lens = lens
    _look_at(camera, eye, target)
    collection.objects.link(camera)
    scene.camera = camera
    # Out of the artist's way in the viewport; the eye in the outliner brings it back. Renders show it.
    bpy.context.view_layer.layer_collection.children[collection.name].hide_viewport = True
    _render_settings(scene)


def _render_settings(scene: bpy.types.Scene) -> None:
    render = scene.render
    render.engine = "BLENDER_EEVEE_NEXT"
    render.resolution_x = render.resolution_y = 720
    render.dither_intensity = 0.0  # noise would make the pictures several times larger
    # The same in every Blender; the default view transform is not.
    scene.view_settings.view_transform = "Standard"
    scene.eevee.taa_render_samples = 16
    scene.eevee.use_gtao = True
    scene.eevee.gtao_distance = 0.3
    scene.eevee.use_soft_shadows = True
    scene.cycles.samples = 32
    scene.cycles.max_bounces = 4
    # For Workbench, where there is neither.
    shading = scene.display.shading
    shading.color_type = "VERTEX"
    shading.show_cavity = True
    shading.show_shadows = True


def _ground(color: Color, target: Triple, eye: Triple) -> bpy.types.Object:
    """A floor that bends up into a wall behind the subject, turned towards the camera."""
    profile = [(-12.0, 0.0), (2.2, 0.0)]
    profile += [(2.2 + 1.5 * sin(a), 1.5 - 1.5 * cos(a)) for a in np.linspace(0.0, pi / 2, 12)[1:]]
    profile += [(3.7, 8.0)]
    n = len(profile)
    vertices = [(x, y, z) for x in (-20.0, 20.0) for y, z in profile]
    data = bpy.data.meshes.new("Ground")
    data.from_pydata(vertices, [], [(i, n + i, n + i + 1, i + 1) for i in range(n - 1)])
    data.polygons.foreach_set("use_smooth", [True] * (n - 1))
    data.materials.append(material(Finish("Ground", color, roughness=0.9, specular=0.2)))
    ground = bpy.data.objects.new("Ground", data)
    ground.rotation_euler.z = np.arctan2(target[1] - eye[1], target[0] - eye[0]) - pi / 2
    return ground


def _light(lamp: Lamp, target: Triple, scale: float) -> bpy.types.Object:
    light = bpy.data.lights.new(lamp.name, "AREA")
    light.shape = "DISK"
    light.size = lamp.size * scale
    light.energy = lamp.watts * scale**2
    light.color = lamp.color
    light.specular_factor = lamp.specular
    obj = bpy.data.objects.new(lamp.name, light)
    _look_at(obj, [scale * x for x in lamp.place], target)
    return obj


def _look_at(obj: bpy.types.Object, eye: Sequence[float], target: Triple) -> None:
    obj.location = eye
    obj.rotation_euler = (Vector(target) - Vector(eye)).to_track_quat("-Z", "Y").to_euler()


def animate(obj: bpy.types.Object, moves: Sequence[Move], pivot: Triple | None = None) -> None:
    """Keyframes an object relative to where it is now; it turns around ``pivot``, a place in its parent's space."""
    rest = obj.location.copy()
    centre = Vector(pivot) if pivot else rest
    obj.rotation_mode = "XYZ"
    for move in _with_midways(moves) if pivot else moves:
        turn, tilt = (Euler([radians(a) for a in angles]).to_matrix() for angles in (move.turn, move.tilt))
        obj.location = centre + turn @ (rest - centre) + Vector(move.shift)
        obj.rotation_euler = (turn @ tilt).to_euler("XYZ", obj.rotation_euler)
        obj.keyframe_insert("location", frame=move.frame)
        obj.keyframe_insert("rotation_euler", frame=move.frame)
    obj.location = rest
    obj.rotation_euler = (0.0, 0.0, 0.0)


def _with_midways(moves: Sequence[Move]) -> list[Move]:
    """The moves with one more between each two: around a pivot the straight way would be a short cut."""
    result = [moves[0]]
    for a, b in pairwise(moves):
        if b.frame - a.frame > 3:
            halves = (_middle(p, q) for p, q in zip(a[1:], b[1:], strict=True))
            result.append(Move((a.frame + b.frame) // 2, *halves))
        result.append(b)
    return result


def _middle(a: Triple, b: Triple) -> Triple:
    return 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])


def save(path: Path, active: bpy.types.Object) -> None:
    """Saves the file, compressed, at frame 1 with ``active`` selected."""
    bpy.context.scene.frame_set(1)
    for obj in bpy.context.view_layer.objects:
        obj.select_set(obj == active)
    bpy.context.view_layer.objects.active = active
    _set_views(bpy.context.scene)
    bpy.context.preferences.filepaths.save_version = 0  # no .blend1 beside it
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True, copy=True)


def _set_views(scene: bpy.types.Scene) -> None:
    """The 3D views of the file's windows look from where the camera does, in the models' colours."""
    areas = [area for screen in bpy.data.screens for area in screen.areas if area.type == "VIEW_3D"]
    for space in (area.spaces.active for area in areas):
        view = space.region_3d
        matrix = scene.camera.matrix_world
        view.view_perspective = "PERSP"
        view.view_rotation = matrix.to_quaternion()
        view.view_distance = VIEW_SHARE * matrix.translation.length
        view.view_location = matrix @ Vector((0.0, 0.0, -matrix.translation.length))
        space.shading.color_type = "VERTEX"
        space.overlay.show_relationship_lines = False
