# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of the demo that runs in Blender: installs the add-on, bakes creature.blend, renders. See demo.py.

Usage, in Blender after "--" or in a Python with bpy: demo_in_blender.py ZIP SCENE OUT_DIR [--without-opengl]
"""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

MODULE = "bl_ext.user_default.arap_deform"
PICTURE = (600, 640)  # pixels
STRIP_PICTURE = (225, 290)
STRIP_FRAMES = 8
TELL_EVERY_S = 5.0
SAMPLES = 8
SAMPLES_WITHOUT_DENOISER = 16

Pixels = NDArray[np.float32]


def main(zip_path: Path, scene_path: Path, out: Path, has_opengl: bool) -> None:
    install(zip_path)
    bpy.ops.wm.open_mainfile(filepath=str(scene_path))
    scene = bpy.context.scene
    obj = next(o for o in scene.objects if o.type == "MESH" and len(o.arap.handles))

    say("Baking")
    job = importlib.import_module(f"{MODULE}.bake.keys").BakeJob(obj, scene.frame_start, scene.frame_end)
    while job.step(TELL_EVERY_S):
        say(f"Baking: {job.status}")
    keys = job.finish()
    posed = out / "creature_posed.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(posed), compress=True, copy=True)

    use_engine(scene, has_opengl)
    pictures = render_all(scene, out)
    results = summary(obj, job.all_stats, keys) | {"rendered_by": scene.render.engine}
    (out / "summary.json").write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")
    say(f"Wrote {posed.name}, {', '.join(pictures)}, summary.json")


def install(zip_path: Path) -> None:
    """Installs the add-on as a user would."""
    bpy.ops.extensions.package_install_files(filepath=str(zip_path), repo="user_default", enable_on_install=True)
    if MODULE not in bpy.context.preferences.addons:
        raise RuntimeError(f"The add-on of {zip_path.name} cannot be enabled")


def summary(obj: bpy.types.Object, all_stats: Sequence[Any], keys: Sequence[str]) -> dict[str, Any]:
    iterations = sum(r.iterations for r in all_stats)
    reasons = sorted({r.stop_reason for r in all_stats})
    return {
        "vertices": all_stats[-1].vertices,
        "handles": len(obj.arap.handles),
        "bind_ms": round(all_stats[-1].bind_ms, 2),
        "factorization_ms": round(all_stats[-1].factor_ms, 2),
        "ms_per_iteration": round(sum(r.last_ms for r in all_stats) / max(iterations, 1), 3),
        "iterations_of_all_frames": iterations,
        "energy_of_last_frame_before": all_stats[-1].energy_before,
        "energy_of_last_frame_after": all_stats[-1].energy,
        "stopped": ", ".join(reasons),
        "shape_keys": len(keys),
        "blender": bpy.app.version_string,
    }


def use_engine(scene: bpy.types.Scene, has_opengl: bool) -> None:
    """Chooses what looks good and is fast without a graphics card: Cycles if it can denoise, else Eevee.

    Eevee on the processor takes minutes a picture.
    """
    scene.eevee.taa_render_samples = SAMPLES
    can_denoise = True
    try:
        scene.cycles.denoiser = "OPENIMAGEDENOISE"
    except (AttributeError, TypeError):
        can_denoise = False  # a Blender without Cycles, or built without the denoiser, as Debian's is
    if has_opengl and not can_denoise:
        return
    scene.render.engine = "CYCLES"
    scene.render.use_persistent_data = True
    scene.cycles.samples = SAMPLES if can_denoise else SAMPLES_WITHOUT_DENOISER
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = can_denoise
    if not can_denoise:
        return
    scene.cycles.denoising_prefilter = "FAST"
    scene.cycles.denoising_quality = "FAST"


def render_all(scene: bpy.types.Scene, out: Path) -> list[str]:
    """Renders before, after, both side by side, and the strip; returns the files' names."""
    frames = np.linspace(scene.frame_start, scene.frame_end, STRIP_FRAMES).round().astype(int).tolist()
    n = STRIP_FRAMES + 2
    before = render(scene, scene.frame_start, PICTURE, out / "before.png", f"1 of {n}")
    after = render(scene, scene.frame_end, PICTURE, out / "after.png", f"2 of {n}")
    save_picture(np.concatenate([before, after], axis=1), out / "before_after.png")
    part = out / "part.png"
    strip = [render(scene, frame, STRIP_PICTURE, part, f"{i} of {n}") for i, frame in enumerate(frames, 3)]
    part.unlink()
    save_picture(np.concatenate(strip, axis=1), out / "strip.png")
    return ["before.png", "after.png", "before_after.png", "strip.png"]


def render(scene: bpy.types.Scene, frame: int, size: tuple[int, int], path: Path, which: str) -> Pixels:
    """Renders one frame into ``path``; returns its pixels (height, width, 4), bottom row first."""
    say(f"Rendering picture {which}, frame {frame}")
    scene.frame_set(frame)
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    pixels = np.empty(size[0] * size[1] * 4, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(size[1], size[0], 4)


def save_picture(pixels: Pixels, path: Path) -> None:
    """Saves pixels (height, width, 4), bottom row first, as they are."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.new(path.stem, width, height)
    image.pixels.foreach_set(np.ascontiguousarray(pixels, dtype=np.float32).ravel())
    image.filepath_raw = str(path)
    image.file_format = "PNG"
    image.save()
    bpy.data.images.remove(image)


def say(text: str) -> None:
    print(f"demo: {text}", flush=True)


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    zip_path, scene_path, out = (Path(a).resolve() for a in arguments[:3])
    main(zip_path, scene_path, out, has_opengl="--without-opengl" not in arguments)
