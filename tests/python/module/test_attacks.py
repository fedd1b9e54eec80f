# SPDX-License-Identifier: GPL-3.0-or-later
"""What attacks the module: random calls, no memory, no mesh. The long runs are in tests/attack."""

import operator
import re
import subprocess
import sys
from collections.abc import Callable

import arap_native
import fuzz_module
import pytest


def test_random_calls_find_nothing():
    fuzzer = fuzz_module.Fuzzer(seed=1)
    for _ in range(150):
        fuzzer.one_case()
    assert fuzzer.findings == []


CLASSES = [
    each
    for name, each in vars(arap_native).items()
    if isinstance(each, type) and not issubclass(each, Exception) and name in arap_native.__all__
]


@pytest.mark.parametrize("its_class", CLASSES)
def test_an_instance_that_only_new_has_made_says_so(its_class):
    bare = its_class.__new__(its_class)
    attributes = [name for name in dir(its_class) if isinstance(getattr(its_class, name), property)]
    for read in [repr, *(operator.attrgetter(name) for name in attributes)]:
        with pytest.raises(TypeError, match=f"^this {its_class.__name__} is empty, because only __new__ was called$"):
            read(bare)


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

# No order of elimination keeps the factor of a soup small.
FACTOR_WITHOUT_MEMORY = """
import resource, numpy as np, arap_native, zoo
mesh = zoo.KINDS["soup"](6_000, np.random.default_rng(0))
solver = arap_native.SurfaceArap(*mesh)
solver.set_constraints(np.arange(3, dtype=np.int32))
limit = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize() + 60_000_000
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
try:
    solver.set_constraints(np.arange(2, dtype=np.int32))
except MemoryError as error:
    print(error)
assert len(solver.solve(mesh.positions[:3]).positions) == 6_000, "the former set stays"
"""

CAGE_WITHOUT_MEMORY = """
import resource, numpy as np, arap_native, sample_meshes
mesh = sample_meshes.tube()
cage = arap_native.make_cage(*mesh, cells=40)
model = arap_native.CageArap(*mesh, options=arap_native.CageArapOptions(energy="cage"), cage=cage)
limit = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize() + 60_000_000
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
try:
    model.set_constraints(np.arange(12, dtype=np.int32))
except MemoryError as error:
    print(error)
"""

# Specks share no control points.
LATTICE_WITHOUT_MEMORY = """
import resource, numpy as np, arap_native, sample_meshes
specks = [sample_meshes.ball(place, 0.01, 4, 5) for place in np.random.default_rng(0).uniform(0.0, 1.0, (4_000, 3))]
mesh = sample_meshes.joined(*specks)
limit = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize() + 100_000_000
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
try:
    arap_native.LatticeArap(*mesh)
except MemoryError as error:
    print(error)
"""

HARMONIC_WITHOUT_MEMORY = """
import resource, numpy as np, arap_native, sample_meshes
mesh = sample_meshes.ball((0.0, 0.0, 0.0), 1.0)
cage = arap_native.make_cage(*mesh, cells=4)
limit = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize() + 60_000_000
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
options = arap_native.CageOptions(coordinates="harmonic", grid_spacing=0.005)
try:
    arap_native.CageDeformation(mesh.positions, *cage, options=options)
except MemoryError as error:
    print(error)
"""

# No thread can be made: each would take more memory for its stack than there is.
WITHOUT_THREADS = """
import resource, numpy as np, arap_native, zoo
mesh = zoo.KINDS["grid"](20_000, np.random.default_rng(0))
solver = arap_native.SurfaceArap(*mesh, options=arap_native.Options(threads=4))
solver.set_constraints(np.arange(2, dtype=np.int32))
print(np.abs(solver.solve(mesh.positions[:2]).positions - mesh.positions).max() < 1e-3)
"""

linux_only = pytest.mark.skipif(sys.platform != "linux", reason="limits of memory as on Linux")


@linux_only
def test_too_little_memory_is_said_in_words():
    needed = r"this mesh needs about \d+ MB of memory, but there are only \d+ MB; close other programs or .+"
    assert re.fullmatch(needed, printed(WITHOUT_MEMORY))


@linux_only
def test_a_factor_that_cannot_fit_is_refused_before_memory_runs_out():
    needed = r"the factor of this mesh needs about \d+ MB of memory, but there are only \d+ MB; .+"
    assert re.fullmatch(needed, printed(FACTOR_WITHOUT_MEMORY))


@linux_only
def test_constraints_of_a_cage_that_cannot_fit_are_refused():
    needed = r"a cage of so many vertices needs about \d+ MB of memory, but there are only \d+ MB; .+"
    assert re.fullmatch(needed, printed(CAGE_WITHOUT_MEMORY))


@linux_only
@pytest.mark.parametrize(
    ("script", "what"),
    [
        (LATTICE_WITHOUT_MEMORY, "the lattice of this mesh"),
        (HARMONIC_WITHOUT_MEMORY, "the grid of harmonic coordinates"),
    ],
)
def test_a_grid_that_cannot_fit_is_refused_before_it_is_made(script, what):
    assert re.fullmatch(what + r" needs about \d+ MB of memory, but there are only \d+ MB; .+", printed(script))


@linux_only
def test_without_threads_the_caller_does_all():
    assert printed(WITHOUT_THREADS, no_threads) == "True"


def no_threads() -> None:
    """Threads get stacks as large as the limit of the first one's."""
    import resource

    resource.setrlimit(resource.RLIMIT_STACK, (6 << 30, resource.RLIM_INFINITY))
    resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))


def printed(script: str, in_child: Callable[[], None] | None = None) -> str:
    """What a script prints in a process of its own, in which numpy has no threads."""
    env = {"PYTHONPATH": ":".join(sys.path), "OPENBLAS_NUM_THREADS": "1"}
    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False, env=env, preexec_fn=in_child
    )
    assert run.returncode == 0, run.stderr
    return run.stdout.strip()
