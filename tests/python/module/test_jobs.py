# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs: calls in a thread of the module's own, what they leave behind, and what ends them."""

import _thread
import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import arap_native
import numpy as np
import pytest
from busy_solver import BUSY, ENDLESS, HANG_LIMIT_S, held_at_ends, uses
from sample_meshes import ends, tube, twisted_ends

MESH = tube(30, 20)
FOR_EVER = arap_native.SolveOptions(**ENDLESS)


def begin_endless(solver: arap_native.SurfaceArap) -> arap_native.Job:
    return solver.begin_solve(twisted_ends(MESH), FOR_EVER)


def wait_until(is_true) -> None:
    end = time.monotonic() + HANG_LIMIT_S
    while not is_true():
        assert time.monotonic() < end
        time.sleep(0.001)


def is_free(solver: arap_native.SurfaceArap) -> bool:
    try:
        solver.reset()
    except RuntimeError:
        return False
    return True


def test_a_job_does_what_the_call_does():
    job = arap_native.SurfaceArap.begin_bind(*MESH)
    solver, expected = job.result(), held_at_ends(MESH)
    assert (job.is_done, job.fraction, job.result() is solver) == (True, 1.0, True)
    assert solver.begin_set_constraints(ends(MESH)).result() is None
    out = np.empty(MESH.positions.shape, dtype=np.float32)
    result = solver.begin_solve(twisted_ends(MESH), out=out).result()
    assert result.positions is out
    assert np.array_equal(out, expected.solve(twisted_ends(MESH)).positions.astype(np.float32))
    groups = [np.array([5], np.int32), np.array([100, 101], np.int32)]
    for given, group, radius in zip(
        solver.begin_patches(groups, np.array([0.1, 0.2])).result(), groups, (0.1, 0.2), strict=True
    ):
        for array, same in zip(given, expected.patch_around(group, radius), strict=True):
            assert np.array_equal(array, same)


def test_a_job_needs_no_lock_of_python_and_is_no_thread_of_it():
    n_threads = len(sys._current_frames())
    interval = sys.getswitchinterval()
    sys.setswitchinterval(HANG_LIMIT_S)  # whoever wants the lock gets it then
    try:
        job = arap_native.SurfaceArap.begin_bind(*tube(200, 100))
        while not job.is_done:
            assert len(sys._current_frames()) == n_threads
    finally:
        sys.setswitchinterval(interval)
    assert threading.active_count() == 1


def test_a_solver_with_a_job_is_refused_until_that_is_done():
    solver = held_at_ends(MESH)
    job = begin_endless(solver)
    begins = [
        lambda: begin_endless(solver),
        lambda: solver.begin_set_constraints(ends(MESH)),
        lambda: solver.begin_patches([], np.empty(0)),
    ]
    for use in uses(MESH, solver) + begins:
        with pytest.raises(RuntimeError) as caught:
            use()
        assert str(caught.value) == BUSY
    assert (job.wait(0.0), job.is_done, repr(job)) == (False, False, "<Job: 0%>")
    job.cancel()
    assert job.result().stop_reason == "cancelled"
    assert repr(job) == "<Job: done>"
    solver.reset()


def test_what_the_work_raises_comes_out_of_the_result():
    positions = MESH.positions.copy()
    positions[3, 0] = np.nan
    job = arap_native.SurfaceArap.begin_bind(positions, *MESH[1:])
    for _ in range(2):
        with pytest.raises(ValueError, match=r"^rest_positions: vertex 3 "):
            job.result()
    solver = held_at_ends(MESH)
    with pytest.raises(ValueError, match="700"):
        solver.begin_set_constraints(np.array([700], dtype=np.int32)).result()
    with pytest.raises(ValueError, match=r"^targets has shape"):  # at once: nothing has begun
        solver.begin_solve(np.zeros((3, 3)))
    assert solver.solve(twisted_ends(MESH)).stop_reason == "converged"


def test_a_cancelled_job_says_so_and_has_changed_nothing():
    mesh = tube(300, 200)
    job = arap_native.SurfaceArap.begin_bind(*mesh)
    job.cancel()
    with pytest.raises(arap_native.Cancelled):
        job.result()
    solver = held_at_ends(mesh)
    job = solver.begin_set_constraints(ends(mesh)[1:])
    job.cancel()
    with pytest.raises(arap_native.Cancelled):
        job.result()
    assert solver.solve(twisted_ends(mesh), arap_native.SolveOptions(max_iterations=2)).iterations > 0
    job = solver.begin_patches([np.array([v], np.int32) for v in range(2000)], np.full(2000, 0.5))
    job.cancel()
    with pytest.raises(arap_native.Cancelled):
        job.result()


def test_a_job_that_is_let_go_ends_and_its_solver_is_free():
    solver = held_at_ends(MESH)
    out = np.empty(MESH.positions.shape, dtype=np.float32)
    job = solver.begin_solve(twisted_ends(MESH), FOR_EVER, out=out)
    del out
    del job
    wait_until(lambda: is_free(solver))


def test_a_solver_that_is_let_go_stays_for_its_job():
    solver = held_at_ends(MESH)
    job = begin_endless(solver)
    del solver
    job.cancel()
    assert job.result().stop_reason == "cancelled"


def test_waiting_has_a_limit_and_hears_an_interrupt():
    job = begin_endless(held_at_ends(MESH))
    assert not job.wait(0.01)
    for bad in (-1.0, float("nan")):
        with pytest.raises(ValueError, match=r"^timeout_s = .*, must be 0 or more$"):
            job.wait(bad)
    former = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.05, _thread.interrupt_main)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            job.wait()
    finally:
        signal.signal(signal.SIGINT, former)
        timer.join()
    assert not job.is_done
    job.cancel()
    assert job.wait()


def test_only_begin_makes_a_job():
    with pytest.raises(TypeError):
        arap_native.Job()


def test_patches_name_what_is_wrong():
    solver = held_at_ends(MESH)
    with pytest.raises(TypeError, match=r"^around is of type int, expected a list of arrays of integers$"):
        solver.begin_patches(1, np.zeros(1))
    with pytest.raises(ValueError, match=r"^an array of around has dtype float64, expected integers$"):
        solver.begin_patches([np.zeros(1)], np.zeros(1))
    with pytest.raises(ValueError, match=r"^radii has shape \(2,\), expected \(1,\): one entry per patch$"):
        solver.begin_patches([np.zeros(1, np.int32)], np.zeros(2))


def test_a_result_that_could_not_be_made_is_missed_in_words():
    testcapi = pytest.importorskip("_testcapi", reason="this Python has no module that refuses memory")
    solver = held_at_ends(MESH)
    around = np.array([5], np.int32)
    told = set()
    for nth in range(60):
        job = solver.begin_patches([around], np.array([0.1]))
        job.wait()
        with contextlib.suppress(MemoryError, RuntimeError):
            testcapi.set_nomemory(nth, nth + 1)
            job.result()
        testcapi.remove_mem_hooks()
        try:
            patches = job.result()
        except RuntimeError as error:
            told.add(str(error))
        else:
            assert len(patches[0]) == 3
    (message,) = told
    assert message.startswith("the result of this job is not there, because an earlier call of result() has failed")


PRELUDE = """
import builtins, os, sys
import numpy as np
import arap_native
from sample_meshes import ends, tube, twisted_ends

mesh = tube(30, 20)
solver = arap_native.SurfaceArap(*mesh)
solver.set_constraints(ends(mesh), np.ones(40))
begin_endless = lambda: solver.begin_solve(
    twisted_ends(mesh), arap_native.SolveOptions(max_iterations=10**9, accuracy=0)
)
"""


def run_python(code: str, **options) -> str:
    run = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", PRELUDE + code],
        cwd=Path(__file__).parents[1],
        capture_output=True,
        text=True,
        timeout=HANG_LIMIT_S,
        check=False,
        **options,
    )
    assert (run.returncode, run.stderr) == (0, "")
    return run.stdout


@pytest.mark.parametrize("keep", ["job = begin_endless()", "builtins.job = begin_endless()", "begin_endless()"])
def test_python_exits_cleanly_while_a_job_is_under_way(keep):
    run_python(keep)


def test_no_job_begins_while_python_exits():
    code = """
import atexit
class AtExit:
    def __del__(self):
        try:
            begin_endless()
        except RuntimeError as error:
            print(error, flush=True)
builtins.at_exit = AtExit()
"""
    assert run_python(code) == "Python is about to exit: no job can be begun\n"


def test_an_array_may_begin_a_job_when_it_is_freed():
    run_python(
        """
class Out(np.ndarray):
    def __del__(self):
        begun.append(arap_native.SurfaceArap.begin_bind(*mesh))

def begin_into(solver):
    solver.set_constraints(ends(mesh), np.ones(40))
    out = np.empty(mesh.positions.shape, np.float32).view(Out)
    return solver.begin_solve(twisted_ends(mesh), arap_native.SolveOptions(max_iterations=10**9, accuracy=0), out=out)

begun = []
first = begin_into(arap_native.SurfaceArap(*mesh))
second = begin_into(arap_native.SurfaceArap(*mesh))
first.cancel()
first.wait()
del first
assert not begun
third = begin_endless()  # forgets the first, which lets go of its array
assert len(begun) == 1 and begun[0].result().n_vertices == 600
for job in (second, third):
    assert not job.is_done
    job.cancel()
    assert job.result().stop_reason == "cancelled"
"""
    )


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_a_forked_child_has_lost_the_jobs_under_way_and_begins_its_own():
    code = """
done = solver.begin_patches([np.zeros(1, np.int32)], np.array([.1]))
done.wait()
job = begin_endless()
if os.fork() == 0:
    assert len(done.result()) == 1
    assert job.is_done and job.wait()
    try:
        job.result()
    except RuntimeError as error:
        print(error, flush=True)
    assert arap_native.SurfaceArap.begin_bind(*mesh).result().n_vertices == 600
    sys.exit()
assert os.wait()[1] == 0
assert not job.wait(0.01)
"""
    assert run_python(code) == (
        "this job was begun before the process was forked, and only the parent goes on with it: begin it in this "
        "process\n"
    )


WITHOUT_A_THREAD = """
import resource
room = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize() + 500_000_000
resource.setrlimit(resource.RLIMIT_AS, (room, room))
"""
AT_ONCE = """
job = arap_native.SurfaceArap.begin_bind(*mesh)
assert job.is_done and job.result().n_vertices == 600
"""
# The work ends only if the other thread gets the GIL meanwhile, and ends all jobs as Python's exit does.
WITHOUT_THE_GIL = f"""
import atexit, threading
sys.setswitchinterval(1000)  # only who lets go of the GIL gives it to another
may_end = threading.Lock()
may_end.acquire()
ending = threading.Thread(target=lambda: (may_end.acquire(), atexit._run_exitfuncs()))
ending.start()
{WITHOUT_A_THREAD}
targets = twisted_ends(mesh)  # before: numpy lets go of the GIL, too
options = arap_native.SolveOptions(max_iterations=10**9, accuracy=0)
may_end.release()
job = solver.begin_solve(targets, options)
ending.join()
assert job.is_done and job.result().stop_reason == "cancelled"
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
@pytest.mark.parametrize("code", [WITHOUT_A_THREAD + AT_ONCE, WITHOUT_THE_GIL], ids=["at once", "without the GIL"])
def test_without_a_thread_the_work_is_done_at_once(code):
    import resource

    gigabyte = 1 << 30  # of stack for each thread, more than there is room for
    run_python(
        code,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_STACK, (gigabyte, gigabyte)),
    )


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the limit decides on the stacks of threads on Linux")
def test_half_the_stack_of_a_thread_of_macos_is_enough():
    import resource

    run_python(
        """
big = tube(200, 100)
solver = arap_native.SurfaceArap.begin_bind(*big, options=arap_native.Options(threads=2)).result()
solver.begin_set_constraints(ends(big)).result()
solver.begin_solve(twisted_ends(big), arap_native.SolveOptions(max_iterations=3)).result()
solver.begin_patches([ends(big)[:1]], np.array([.5])).result()
""",
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_STACK, (256 * 1024, 256 * 1024)),
    )
