# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses must be the same on every platform, with every set of instructions.

    python same_poses.py write FILE      poses of this platform's module
    python same_poses.py compare FILE    fails if this platform's poses differ by more than 1e-6 of the diagonal

tests/python must be on the path.
"""

import itertools
import os
import sys
import time

import arap_native
import numpy as np
import sample_meshes

TOLERANCE = 1e-6
# The first is solved in double precision; the others bind and solve in single and end in double, on several threads.
MODELS = (arap_native.SurfaceArap, arap_native.LatticeArap)
TUBES = {"small": (12, 8), "middle": (60, 40), "large": (240, 110)}


def isas() -> list[str]:
    """The sets of instructions that this machine can run."""
    found = []
    for isa in ("baseline", "avx2", "avx512"):
        os.environ["ARAP_ISA"] = isa
        try:
            pose(sample_meshes.tube())
            found.append(isa)
        except ValueError:
            pass  # the machine lacks it
    return found


def pose(mesh: sample_meshes.Mesh, model: type[arap_native.Model] = arap_native.SurfaceArap) -> np.ndarray:
    solver = model(*mesh)
    solver.set_constraints(sample_meshes.ends(mesh))
    return solver.solve(sample_meshes.twisted_ends(mesh)).positions


def main() -> int:
    act, path = sys.argv[1:]
    expected = np.load(path) if act == "compare" else {}
    poses, worst = {}, 0.0
    for isa in isas():
        os.environ["ARAP_ISA"] = isa
        for model, (tube, size) in itertools.product(MODELS, TUBES.items()):
            mesh, name = sample_meshes.tube(*size), f"{model.__name__} {tube}"
            start = time.perf_counter()
            poses[name] = pose(mesh, model)
            seconds = time.perf_counter() - start
            error = np.abs(poses[name] - expected[name]).max() / mesh.diagonal if expected else 0.0
            worst = max(worst, error)
            print(f"{isa:9} {name:18} {len(mesh.positions):6} vertices, {seconds:6.3f} s, differs by {error:.1e}")
    if act == "write":
        np.savez(path, **poses)
    print(f"{'1 passed, 0' if worst <= TOLERANCE else '0 passed, 1'} failed")
    return 0 if worst <= TOLERANCE else 1


if __name__ == "__main__":
    sys.exit(main())
