# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of deformed meshes; runs in a Python that has bpy.

    python panels.py FOLDER [NAME...]

Renders each NAME.npz of the folder that measure.runs.quality left (all where none is named) into NAME.png: what is held
is grey, what is moved blue, the rest clay.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

PIXELS = 480
CLAY, HELD, MOVED = (0.95, 0.70, 0.48), (0.60, 0.60, 0.62), (0.28, 0.52, 0.85)
DISTANCE = 10.0  # of the camera, which is orthographic


def render(data: Any, path: Path) -> None:
    """One picture of what measure.runs.quality.save wrote."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.collection.objects.link(
        bpy.data.objects.new("Mesh", mesh(data["positions"], data["triangles"], data["part"]))
    )
    scene.camera = camera(Vector(data["eye"]), Vector(data["middle"]), float(data["height"]))
    scene.collection.objects.link(scene.camera)
    use_workbench(scene)
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def mesh(positions: Any, triangles: Any, part: Any) -> bpy.types.Mesh:
    """A smooth mesh whose faces have the colour of their parts; a face is in a part where all its corners are."""
    result = bpy.data.meshes.new("Mesh")
    result.vertices.add(len(positions))
    result.loops.add(triangles.size)
    result.polygons.add(len(triangles))
    result.vertices.foreach_set("co", positions.astype(np.float32).ravel())
    result.loops.foreach_set("vertex_index", triangles.ravel())
    result.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    result.polygons.foreach_set("use_smooth", np.ones(len(triangles), dtype=bool))
    corners = part[triangles]
    result.polygons.foreach_set("material_index", np.where(np.ptp(corners, axis=1) == 0, corners[:, 0], 0))
    for color in (CLAY, HELD, MOVED):
        material = bpy.data.materials.new("Part")
        material.diffuse_color = (*color, 1.0)
        result.materials.append(material)
    result.update(calc_edges=True)
    return result


def camera(eye: Vector, middle: Vector, height: float) -> bpy.types.Object:
    lens = bpy.data.cameras.new("Camera")
    lens.type = "ORTHO"
    lens.ortho_scale = height
    result = bpy.data.objects.new("Camera", lens)
    result.location = middle + DISTANCE * eye.normalized()
    result.rotation_euler = (-eye).to_track_quat("-Z", "Y").to_euler()
    return result


def use_workbench(scene: bpy.types.Scene) -> None:
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.render.resolution_x = scene.render.resolution_y = PIXELS
    scene.render.dither_intensity = 0.0
    scene.view_settings.view_transform = "Standard"
    scene.display.render_aa = "8"
    shading = scene.display.shading
    shading.light = "MATCAP"
    shading.studio_light = "basic_1.exr"
    shading.color_type = "MATERIAL"
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = (1.0, 1.0, 1.0)


def main() -> None:
    folder, names = Path(sys.argv[1]), sys.argv[2:]
    for path in sorted(folder.glob("*.npz")):
        if not names or path.stem in names:
            with np.load(path) as data:
                render(data, path.with_suffix(".png"))
            print(f"panels: {path.stem}", flush=True)
    sys.stdout.flush()
    os._exit(0)  # bpy 4.5 prints thousands of lines at its exit


if __name__ == "__main__":
    main()
