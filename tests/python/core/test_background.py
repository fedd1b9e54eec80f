# SPDX-License-Identifier: GPL-3.0-or-later
"""Work in the background, with jobs that end when the test says so."""

import math
from dataclasses import dataclass

import pytest
from arap_deform.core.background import Background, Cancelled, part, run, stage


@dataclass
class FakeJob:
    """``outcome`` is what it gives or raises."""

    outcome: object = None
    fraction: float = 0.0
    is_done: bool = False
    is_cancelled: bool = False
    ends_by_itself: bool = False

    def cancel(self):
        self.is_cancelled = True

    def wait(self, time_limit_s):
        self.is_done = self.is_done or (self.ends_by_itself and time_limit_s > 0.0)
        return self.is_done

    def result(self):
        if isinstance(self.outcome, Exception):
            raise self.outcome
        return self.outcome


def both(first, second):
    """Work of two jobs; the first takes a fourth of the progress."""
    a = yield from part(stage(first, "The first was cancelled"), 0.0, 0.25)
    b = yield from part(stage(second, "The second was cancelled"), 0.25, 1.0)
    return a, b


def test_one_stage_follows_the_other_and_the_work_has_a_result():
    first, second = FakeJob("a"), FakeJob("b")
    work = Background(both(first, second))
    first.fraction = 0.5
    assert (work.step(), work.fraction, work.is_done, work.result()) == (True, 0.125, False, None)
    first.is_done = True
    assert (work.step(), work.fraction) == (True, 0.25)
    second.fraction, second.is_done = 1.0, True
    assert (work.step(), work.fraction, work.is_done) == (False, 1.0, True)
    assert work.result() == ("a", "b")
    work.drop()
    assert work.result() == ("a", "b"), "nothing is left to drop"
    assert [first.is_cancelled, second.is_cancelled] == [False, False]


def test_a_step_goes_through_as_many_stages_as_end_in_time():
    assert not Background(both(FakeJob("a", is_done=True), FakeJob("b", is_done=True))).step()
    assert not Background(both(FakeJob(ends_by_itself=True), FakeJob(ends_by_itself=True))).step(math.inf)


def test_what_a_stage_raises_ends_the_work_and_comes_out_of_the_result():
    work = Background(both(FakeJob(ValueError("no mesh"), is_done=True), FakeJob()))
    assert not work.step()
    for _ in range(2):
        with pytest.raises(ValueError, match=r"^no mesh$"):
            work.result()


def test_work_that_fails_before_its_first_stage_says_so_in_its_result():
    def steps():
        raise RuntimeError("no module")
        yield

    work = Background(steps())
    assert work.is_done
    with pytest.raises(RuntimeError, match=r"^no module$"):
        work.result()


def test_dropped_work_cancels_its_job_and_begins_no_other():
    first, second = FakeJob(), FakeJob()
    work = Background(both(first, second))
    work.drop()
    first.is_done = True
    assert (first.is_cancelled, work.step(), work.is_done, work.result()) == (True, False, True, None)


def test_run_asks_progress_in_every_stage_and_gives_the_result():
    fractions = []
    jobs = [FakeJob("a", ends_by_itself=True), FakeJob("b", ends_by_itself=True)]
    assert run(both(*jobs), fractions.append) == ("a", "b")
    assert fractions[0] == 0.0
    assert run(both(FakeJob("a", ends_by_itself=True), FakeJob("b", ends_by_itself=True))) == ("a", "b")


def test_run_that_is_stopped_says_what_was_cancelled():
    first, second = FakeJob(is_done=True), FakeJob()
    with pytest.raises(Cancelled, match=r"^The second was cancelled$"):
        run(both(first, second), lambda fraction: fraction < 0.25)
    assert second.is_cancelled


def test_what_progress_raises_drops_the_work():
    job = FakeJob()

    def progress(_fraction):
        raise KeyError("a fault of the script")

    with pytest.raises(KeyError):
        run(both(job, FakeJob()), progress)
    assert job.is_cancelled
