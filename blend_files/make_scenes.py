# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the sample scenes from nothing.

    blender -b --factory-startup --python blend_files/make_scenes.py -- OUT_DIR

Writes bar.blend, cactus.blend, creature.blend and dressed.blend into OUT_DIR. Blender 4.2 made the files in this
folder, so that every later one opens them.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "blend_files"), str(ROOT / "addon")]
sys.dont_write_bytecode = True

import arap_deform  # noqa: E402 - found through the path set above
from arap_deform import api  # noqa: E402
from scenes import blender_scene, samples  # noqa: E402


def main() -> None:
    parser = argparse.ArgumentParser(prog="make_scenes.py", description="Makes the sample scenes.")
    parser.add_argument("out", type=Path, help="folder for the .blend files")
    args = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [])
    out = args.out.resolve()
    out.mkdir(parents=True, exist_ok=True)

    arap_deform.register()
    try:
        makers = {
            "bar": samples.make_bars,
            "cactus": samples.make_cactus,
            "creature": samples.make_creature,
            "dressed": samples.make_dressed,
        }
        for name, make in makers.items():
            blender_scene.save(out / f"{name}.blend", make(api))
    finally:
        arap_deform.unregister()


if __name__ == "__main__":
    main()
