# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress, cancelling, interrupts, threads, and what they leave behind: memory and references."""

import _thread
import ctypes
import gc
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

import arap_native
import numpy as np
import pytest
from busy_solver import BUSY, ENDLESS, HANG_LIMIT_S, held_at_ends, uses
from sample_meshes import Mesh, ends, tube, twisted_ends


class Boom(Exception):
    pass


def boom(fraction: float) -> bool:
    raise Boom(fraction)


# ------------------------------------------------------------------------------------------------------- progress


def calls(mesh: Mesh, solver: arap_native.SurfaceArap) -> dict[str, Callable]:
    """The three long calls, each to be given progress."""
    vertices = ends(mesh)[1:]
    return {
        "bind": lambda progress: arap_native.SurfaceArap(*mesh, progress=progress),
        "set_constraints": lambda progress: solver.set_constraints(vertices, np.ones(len(vertices)), progress=progress),
        "solve": lambda progress: solver.solve(
            twisted_ends(mesh, 2.0), arap_native.SolveOptions(max_iterations=20), progress=progress
        ),
    }


@pytest.mark.parametrize("name", ["bind", "set_constraints", "solve"])
def test_progress_gives_rising_fractions_in_the_calling_thread(name):
    mesh = tube(30, 20)
    fractions, threads = [], set()

    def progress(fraction):  # returns None: goes on
        fractions.append(fraction)
        threads.add(threading.get_ident())

    calls(mesh, held_at_ends(mesh))[name](progress)
    assert fractions
    assert fractions == sorted(fractions)
    assert fractions[0] >= 0
    assert fractions[-1] <= 1
    assert all(type(fraction) is float for fraction in fractions)
    assert threads == {threading.get_ident()}


@pytest.mark.parametrize("name", ["bind", "set_constraints", "solve"])
def test_an_exception_in_progress_comes_through_and_nothing_has_changed(name):
    mesh = tube(30, 20)
    solver = held_at_ends(mesh)
    before = solver.solve(twisted_ends(mesh)).positions
    with pytest.raises(Boom):
        calls(mesh, solver)[name](boom)
    assert np.array_equal(solver.positions, before)
    solver.solve(twisted_ends(mesh, 2.0))


@pytest.mark.parametrize("answer", [False, 0, np.False_])
def test_a_cancelled_bind_or_change_of_constraints_raises_cancelled_and_a_solve_says_so(answer):
    mesh = tube(30, 20)
    long_calls = calls(mesh, held_at_ends(mesh))
    for name in ("bind", "set_constraints"):
        with pytest.raises(arap_native.Cancelled):
            long_calls[name](lambda fraction: answer)
    assert long_calls["solve"](lambda fraction: answer).stop_reason == "cancelled"


def test_what_progress_answers_has_to_be_true_or_false():
    mesh = tube(30, 20)
    with pytest.raises(ValueError, match="truth value of an array"):
        held_at_ends(mesh).solve(twisted_ends(mesh), progress=lambda fraction: np.zeros(2))


@pytest.fixture
def heard_interrupts():
    """Programs that a shell starts in the background ignore SIGINT, and so does what they start."""
    former = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, former)


def is_at_work(solver: arap_native.SurfaceArap) -> bool:
    """Whether another thread solves; it has to let go of Python's lock for that, or nobody could ask.

    To ask is a use of the solver too, and may refuse the other thread: that one has to try again.
    """
    try:
        solver.n_factorizations  # noqa: B018 - refused while the solver is at work
    except RuntimeError:
        return True
    return False


def solve_for_ever(mesh: Mesh, solver: arap_native.SurfaceArap) -> arap_native.SolveResult:
    """Tries again where is_at_work() has refused it."""
    while True:
        with suppress(RuntimeError):
            return solver.solve(twisted_ends(mesh), arap_native.SolveOptions(**ENDLESS, time_limit_s=HANG_LIMIT_S))


@pytest.mark.usefixtures("heard_interrupts")
def test_other_threads_run_during_a_solve_and_an_interrupt_ends_it():
    mesh = tube(30, 20)
    solver = held_at_ends(mesh)

    def interrupt():
        while not is_at_work(solver):
            time.sleep(0.001)
        _thread.interrupt_main()

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        solve_for_ever(mesh, solver)
    thread.join()
    assert np.allclose(solver.positions, mesh.positions, rtol=0, atol=1e-12)


@pytest.mark.usefixtures("heard_interrupts")
def test_an_interrupt_during_progress_ends_the_solve():
    mesh = tube(30, 20)
    solver = held_at_ends(mesh)
    with pytest.raises(KeyboardInterrupt):
        solver.solve(twisted_ends(mesh), progress=lambda fraction: signal.raise_signal(signal.SIGINT))
    assert np.allclose(solver.positions, mesh.positions, rtol=0, atol=1e-12)


# -------------------------------------------------------------------------------------------------------- threads


def test_several_solvers_in_several_threads():
    mesh = tube(40, 24)
    angles = [0.2 * k for k in range(1, 9)]

    def pose(angle: float) -> np.ndarray:
        solver = held_at_ends(mesh)
        for part in (0.5, 1.0):
            result = solver.solve(twisted_ends(mesh, part * angle), progress=lambda fraction: True)
        return result.positions

    expected = [pose(angle) for angle in angles]
    with ThreadPoolExecutor(4) as pool:
        given = list(pool.map(pose, angles))
    assert all(np.array_equal(*pair) for pair in zip(given, expected, strict=True))


def test_one_solver_in_two_threads_is_refused_and_the_first_call_goes_on():
    mesh = tube(30, 20)
    solver = held_at_ends(mesh)
    expected = held_at_ends(mesh).solve(twisted_ends(mesh)).positions
    inside, may_go_on = threading.Event(), threading.Event()

    def progress(fraction):
        inside.set()
        return may_go_on.wait(HANG_LIMIT_S)

    with ThreadPoolExecutor(1) as pool:
        first = pool.submit(solver.solve, twisted_ends(mesh), progress=progress)
        assert inside.wait(HANG_LIMIT_S)
        for use in uses(mesh, solver):
            with pytest.raises(RuntimeError) as caught:
                use()
            assert str(caught.value) == BUSY
        assert (solver.n_vertices, solver.n_parts, len(solver.part_of_vertex)) == (600, 1, 600)
        assert "600 vertices" in repr(solver)
        may_go_on.set()
        assert np.array_equal(first.result().positions, expected)
    solver.reset()


def test_a_solver_used_below_its_own_progress_is_refused():
    mesh = tube(30, 20)
    solver = held_at_ends(mesh)
    for use in uses(mesh, solver):
        with pytest.raises(RuntimeError) as caught:
            solver.solve(twisted_ends(mesh), progress=lambda fraction, use=use: use())
        assert str(caught.value) == BUSY
    assert np.allclose(solver.positions, mesh.positions, rtol=0, atol=1e-12)


def test_hammering_one_solver_from_many_threads_never_breaks_it():
    mesh = tube(30, 20)
    solver = held_at_ends(mesh)

    with ThreadPoolExecutor(4) as pool:
        hammering = [pool.submit(use) for _ in range(80) for use in uses(mesh, solver)]
    refused = [str(call.exception()) for call in hammering if call.exception()]
    assert set(refused) <= {BUSY}
    assert len(refused) < len(hammering)
    solver.reset()
    expected = held_at_ends(mesh).solve(twisted_ends(mesh)).positions
    assert np.array_equal(solver.solve(twisted_ends(mesh)).positions, expected)


LEAVE_A_SOLVE_BEHIND = """
import threading
import time
from contextlib import suppress
import numpy as np
import arap_native
from sample_meshes import ends, tube, twisted_ends

mesh = tube(30, 20)
solver = arap_native.SurfaceArap(*mesh)
solver.set_constraints(ends(mesh), np.ones(40))
options = arap_native.SolveOptions(max_iterations=10**9, accuracy=0)


def solve():
    while True:
        with suppress(RuntimeError):  # the other thread has looked just now
            solver.solve(twisted_ends(mesh), options, progress={progress})


threading.Thread(target=solve, daemon=True).start()
while True:
    time.sleep(0.001)  # the other thread's turn
    try:
        solver.n_factorizations
    except RuntimeError:  # it is at work
        break
"""


@pytest.mark.parametrize("progress", ["None", "lambda fraction: True"])
def test_python_exits_cleanly_while_a_daemon_thread_solves(progress):
    code = LEAVE_A_SOLVE_BEHIND.format(progress=progress)
    run = subprocess.run(
        [sys.executable, "-c", code],
        cwd=Path(__file__).parents[1],
        capture_output=True,
        text=True,
        timeout=HANG_LIMIT_S,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")


# --------------------------------------------------------------------------------------------------------- memory


def resident_bytes() -> int:
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)  # what earlier tests have freed would hide what is taken now
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_two_hundred_solvers_leave_no_memory_behind():
    mesh = tube(60, 24)

    def use():
        solver = held_at_ends(mesh)
        solver.solve(twisted_ends(mesh), arap_native.SolveOptions(max_iterations=2))
        with pytest.raises(Boom):
            solver.solve(twisted_ends(mesh), progress=boom)
        with pytest.raises(arap_native.Cancelled):
            arap_native.SurfaceArap(*mesh, progress=lambda fraction: False)
        return solver

    for _ in range(20):
        use()
    start = resident_bytes()
    for _ in range(200):
        use()
    grown = resident_bytes() - start
    # Held last: memory that was freed once would hide a leak.
    start = resident_bytes()
    held = [use() for _ in range(20)]
    per_solver = (resident_bytes() - start) / len(held)
    assert per_solver > mesh.positions.nbytes, "the measure sees a solver"
    assert grown < 2 * per_solver, "two hundred leave less behind than two hold"


def test_callbacks_and_arrays_are_let_go():
    mesh = tube(30, 20)
    solver = held_at_ends(mesh)
    targets = twisted_ends(mesh)

    def progress(fraction):
        return True

    counted = [progress, boom, targets, *mesh]
    before = [sys.getrefcount(thing) for thing in counted]
    for _ in range(5):
        solver.solve(targets, progress=progress)
        with pytest.raises(Boom):
            solver.solve(targets, progress=boom)
        arap_native.SurfaceArap(*mesh, progress=progress)
    assert [sys.getrefcount(thing) for thing in counted] == before
