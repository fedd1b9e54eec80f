# SPDX-License-Identifier: GPL-3.0-or-later
"""Names that are still free."""

from arap_deform.core.naming import NAME_BYTES, cut, numbered, sentences, unique


def test_a_free_name_stays():
    assert unique("Hand", {"Foot"}) == "Hand"


def test_a_taken_name_takes_the_first_free_number():
    assert unique("Hand", {"Hand"}) == "Hand.001"
    assert unique("Hand", {"Hand", "Hand.001", "Hand.003"}) == "Hand.002"
    assert numbered("Hand", set()) == "Hand.001"


def test_a_long_name_is_cut_between_letters_so_that_the_number_stays():
    long = "ä" * 40
    found = unique(long, {cut(long)})
    assert found == "ä" * 28 + ".001"
    assert len(found.encode()) <= NAME_BYTES


def test_reasons_make_a_text_that_says_each_once_and_ends():
    assert sentences(["A: do b", "C: do d", "A: do b"]) == "A: do b. C: do d"
    assert sentences([str(i) for i in range(9)], most=2) == "0. 1. And 7 more"
