# SPDX-License-Identifier: GPL-3.0-or-later
"""Results as Markdown, and where they go in the document."""

import pytest
from measure.pages import marks
from measure.pages.compare import acts, inputs
from measure.pages.limbs import cost, limb_cells
from measure.pages.markdown import markdown, not_run_lines, number, replace_section
from measure.pages.peers import near_ms, round_ratio
from measure.pages.quality import together


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "-"), (0.0, "0"), (0.0123449, "0.0123"), (0.000999, "0.000999"), (0.9996, "1.00"),
        (5.206, "5.21"), (9.5959, "9.60"), (51.25, "51.2"), (999.6, "1000"),
        (1283.4, "1283"), (123456.7, "123457"), (-2.5, "-2.50"),
    ],
)  # fmt: skip
def test_numbers_have_three_digits_and_no_exponent(value, text):
    assert number(value) == text


def test_a_table_without_rows_is_empty():
    assert markdown(("mesh", "ms"), [("bar", "2")]) == "| mesh | ms |\n| --- | ---: |\n| bar | 2 |"
    assert markdown(("mesh", "ms"), []) == ""


def test_the_ratio_is_the_median_of_the_rounds():
    theirs, ours = ({"iteration_ms_of_rounds": times} for times in ([20.0, 30.0, 40.0], [1.0, 2.0, 4.0]))
    assert round_ratio(theirs, ours) == 15.0  # of 20, 15, 10
    assert round_ratio(theirs, None) is None


def test_densities_share_a_cell():
    assert together(["48", "50"]) == "48, 50"
    assert together(["0", "0"]) == "0"
    assert together([]) == "-"


def test_what_cannot_run_is_named_once_with_its_reason():
    rows = [{"library": "cgal", "not_run": "no CGAL here"}] * 2 + [{"isa": "avx512", "not_run": "the machine lacks it"}]
    assert not_run_lines(rows) == "- Not run: CGAL: no CGAL here\n- Not run: AVX-512: the machine lacks it"


def test_times_to_near_the_minimum_say_how_much_is_known_of_it():
    row = {"is_converged": True, "near": {"iterations": 8, "ms": 16.0}, "runs": [[4, 8.0, 0.5], [8, 16.0, 0.4]]}
    assert near_ms(row) == "16.0"
    assert near_ms(row | {"is_converged": False}) == "16.0*", "the minimum is not the library's own"
    assert near_ms(row | {"near": None}) == "not in 0.0160 s"


def test_a_section_is_replaced_between_its_markers_alone():
    document = "a\n<!-- measured: x -->\nold\n<!-- end of x -->\nb <!-- measured: y --><!-- end of y -->\n"
    new = replace_section(document, "x", r"new \1")
    assert new == document.replace("\nold\n", "\n\nnew \\1\n\n")
    assert replace_section(new, "x", r"new \1") == new


@pytest.mark.parametrize("document", ["", "<!-- measured: x -->", 2 * "<!-- measured: x --><!-- end of x -->"])
def test_a_document_without_the_section_is_refused(document):
    with pytest.raises(ValueError, match="must have one"):
        replace_section(document, "x", "new")


def test_skinning_has_no_iterations_and_no_seconds():
    row = {"volume": 0.9, "section": 0.0, "max_deg": 177.0, "iterations": 0, "s": 0.0}
    assert limb_cells(row) == ("0.900", "0.000", "177", "-", "-")
    assert limb_cells(row | {"iterations": 57, "s": 0.34})[3:] == ("57", "0.34")


def test_a_cost_that_was_not_measured_has_no_row():
    row = {"model": "solid", "n_vertices": 2_000_000, "bind_s": 1.0, "constraints_s": 0.5, "frame_s": 0.05}
    table = cost([row | {"bytes_a_vertex": 150.0}, {"model": "firm", "not_run": "no memory"}])
    assert table.splitlines()[2:] == ["| 2000000 | Solid | 1.0 | 0.50 | 50 | - | 300 | 150 |"]


@pytest.mark.parametrize(("worst", "mark"), [(0.95, "●●●"), (0.9, "●●●"), (0.89, "●●"), (0.5, "●"), (0.2, "○")])
def test_a_model_has_the_mark_of_its_worst_task(worst, mark):
    criterion = marks.Criterion("thin", "", marks.lowest("thin", "bend", "twist"), (0.9, 0.75, 0.5))
    data = {"tasks": {"bend": {"rows": {"solid": {"thin": 1.0}}}, "twist": {"rows": {"solid": {"thin": worst}}}}}
    assert criterion.mark(data, "solid") == mark


def test_fewer_degrees_are_more_marks():
    criterion = marks.Criterion("smooth", "", marks.highest("max_deg"), (10, 20, 45))
    data = {"tasks": {"bend": {"rows": {"solid": {"max_deg": 12.0}, "cage": {"max_deg": 10.0}}}}}
    assert [criterion.mark(data, model) for model in ("solid", "cage")] == ["●●", "●●●"]


@pytest.mark.parametrize("row", [{}, {"thin": None}, {"not_run": "it has no inside"}])
def test_a_model_that_did_not_do_all_tasks_has_no_mark(row):
    criterion = marks.Criterion("thin", "", marks.lowest("thin", "bend", "twist"), (0.9, 0.75, 0.5))
    data = {"tasks": {"bend": {"rows": {"cage": {"thin": 1.0}}}, "twist": {"rows": {"cage": row}}}}
    assert criterion.mark(data, "cage") == "-"


def test_models_that_are_given_the_same_share_a_line():
    given = {"solid": "Targets.", "Poisson": "Targets and turns.", "surface": "Targets."}
    assert inputs(given) == "- solid; surface: Targets.\n- Poisson: Targets and turns."


def test_the_same_acts_are_counted():
    assert acts(["a pin", "a bone", "a bone"]) == "a pin, 2 times a bone"
