# SPDX-License-Identifier: GPL-3.0-or-later
"""What is shown of that for which the artist waits, and when. A fake clock."""

from dataclasses import replace

import pytest
from arap_deform.core.tracker import HandleTracker
from arap_deform.ui.waits import SHOWN_AFTER_S, Wait, Waiters, wait_for_bind
from fake_engine import FakeEngineScene


class Binding:
    """A mesh that is bound, and the time."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.now = 100.0
        self.scene = FakeEngineScene(is_fit=False)
        self.tracker = HandleTracker(self.scene, lambda: self.now)
        self.tracker.begin()

    def wait(self) -> Wait | None:
        return wait_for_bind(self.name, self.tracker)


def shown_text(waiters: Waiters) -> str:
    return "" if waiters.shown is None else waiters.shown[1].text


def test_a_bind_is_shown_only_after_half_a_second() -> None:
    waiters, binding = Waiters(), Binding("Bar")
    waiters.add(binding)
    binding.now += 0.99 * SHOWN_AFTER_S
    assert (waiters.look(), waiters.shown, waiters.is_empty) == (False, None, False)
    binding.now += 0.02 * SHOWN_AFTER_S
    assert waiters.look()
    assert waiters.shown == (binding, binding.wait())
    assert shown_text(waiters) == "Preparing Bar, 50%"


@pytest.mark.parametrize("is_dropped", [True, False])
def test_it_is_gone_with_the_bind_and_the_next_bind_begins_anew(is_dropped: bool) -> None:
    waiters, binding = Waiters(), Binding("Bar")
    waiters.add(binding)
    binding.now += 1.0
    waiters.look()
    if is_dropped:
        binding.tracker.drop()
    else:
        binding.scene.binds[0].is_done = True
        binding.tracker.prepare()
    assert (waiters.look(), waiters.shown, waiters.is_empty) == (True, None, True)
    binding.scene.is_fit = False
    binding.tracker.prepare()
    waiters.add(binding)
    assert (waiters.look(), waiters.shown, waiters.is_empty) == (False, None, False)


def test_only_what_can_be_seen_is_drawn_again() -> None:
    waiters, binding = Waiters(), Binding("Bar")
    waiters.add(binding)
    binding.now += 1.0
    assert waiters.look()
    bind = binding.scene.binds[0]
    for fraction, is_seen in ((0.501, False), (0.51, True)):
        binding.now += 1.0
        bind.fraction = fraction
        assert waiters.look() == is_seen


def test_of_several_the_one_is_shown_that_has_lasted_longest() -> None:
    waiters, first = Waiters(), Binding("First")
    first.now += 1.0
    second = Binding("Second")
    for _ in range(2):  # to add one again is nothing
        for binding in (second, first):
            waiters.add(binding)
    second.now += 0.7
    waiters.look()
    assert shown_text(waiters) == "Preparing First, 50%"
    first.tracker.drop()
    waiters.look()
    assert shown_text(waiters) == "Preparing Second, 50%"


def test_whether_esc_ends_it_is_seen() -> None:
    class Fixed:
        current = Wait("Solve: solving, 20%", 0.2, 1.0)

        def wait(self) -> Wait:
            return self.current

    waiters, fixed = Waiters(), Fixed()
    waiters.add(fixed)
    assert waiters.look()
    fixed.current = replace(fixed.current, seconds=2.0, ends_on_esc=False)
    assert waiters.look()
