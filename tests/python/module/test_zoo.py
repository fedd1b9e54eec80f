# SPDX-License-Identifier: GPL-3.0-or-later
"""What attacks the module: every kind of bad mesh, random calls, no memory. The long runs are in tests/attack."""

import subprocess
import sys

import arap_native
import fuzz_module
import measure_zoo
import pytest
import zoo


@pytest.mark.parametrize("kind", zoo.KINDS)
def test_a_bad_mesh_stays_finite_and_at_rest(kind):
    row = measure_zoo.attack(kind, 300, threads=1)
    assert row["what"] == "ok"


def test_random_calls_find_nothing():
    fuzzer = fuzz_module.Fuzzer(seed=1)
    for _ in range(150):
        fuzzer.one_case()
    assert fuzzer.findings == []


def test_a_solver_without_a_mesh_says_so():
    bare = arap_native.SurfaceArap.__new__(arap_native.SurfaceArap)
    with pytest.raises(TypeError, match=r"only __new__ was called: call SurfaceArap"):
        _ = bare.positions


WITHOUT_MEMORY = """
import resource, numpy as np, arap_native, zoo
mesh = zoo.KINDS["grid"](200_000, np.random.default_rng(0))
limit = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize() + 50_000_000
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
try:
    arap_native.SurfaceArap(*mesh)
except MemoryError as error:
    print(error)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory as on Linux")
def test_too_little_memory_is_said_in_words():
    run = subprocess.run([sys.executable, "-c", WITHOUT_MEMORY], capture_output=True, text=True, check=True, env=env())
    assert run.stdout.strip() == "there is not enough memory for this mesh; close other programs or take a coarser mesh"


def env() -> dict[str, str]:
    """One thread: out of threads is another matter."""
    return {"PYTHONPATH": ":".join(sys.path), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
