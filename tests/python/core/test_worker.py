# SPDX-License-Identifier: GPL-3.0-or-later
"""Work in a thread of its own."""

import threading

import pytest
from arap_deform.core.worker import Binding, is_any_running, wait_for_binds

HANG_LIMIT_S = 600.0


def test_work_runs_beside_and_gives_its_result() -> None:
    binding = Binding(lambda progress: progress(0.25) and "bound")
    binding.start()
    binding.wait(HANG_LIMIT_S)
    assert binding.is_done
    assert binding.fraction == 0.25
    assert binding.result() == "bound"


def test_the_result_raises_what_the_work_raised() -> None:
    def work(_progress: object) -> None:
        raise ValueError("no faces")

    binding = Binding(work)
    binding.start()
    binding.wait(HANG_LIMIT_S)
    with pytest.raises(ValueError, match="no faces"):
        binding.result()


def test_dropping_stops_the_work() -> None:
    def work(progress: object) -> str:
        while progress(0.5):  # type: ignore[operator]
            pass
        return "stopped"

    binding = Binding(work)
    binding.start()
    assert not binding.is_done
    assert is_any_running()
    binding.drop()
    binding.wait(HANG_LIMIT_S)
    assert binding.is_done
    assert not is_any_running()


def test_waiting_ends_with_the_work() -> None:
    may_end = threading.Event()
    binding = Binding(lambda _progress: may_end.wait(HANG_LIMIT_S))
    wait_for_binds()  # nothing to wait for
    binding.start()
    threading.Timer(0.05, may_end.set).start()
    wait_for_binds()
    assert may_end.is_set()
    assert binding.is_done
    assert not is_any_running()


def test_work_waits_for_its_start_and_does_not_begin_if_it_was_dropped() -> None:
    calls: list[object] = []
    binding = Binding(calls.append)
    assert not binding.is_done
    binding.drop()
    binding.start()
    assert (binding.is_done, is_any_running(), calls) == (False, False, [])
