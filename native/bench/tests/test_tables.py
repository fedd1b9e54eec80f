# SPDX-License-Identifier: GPL-3.0-or-later
"""Results as Markdown, and where they go in the document."""

import pytest
from measure import tables, tables_native, tables_peers, tables_quality
from measure.render import replace_section, sections

MACHINE = {"processor": "P", "cores": 2, "memory_gib": 8, "system": "Linux", "load": 0.1, "day": "2026-01-02"}


def peer_row(library, iteration_ms, **more):
    return {
        "library": library, "energy": "spokes", "isa": "", "version": "1.2", "bind_ms": 12.0,
        "iteration_ms": iteration_ms,
        "iteration_ms_of_rounds": [iteration_ms], "cores_used": 1.0, "peak_mb": 100.0, "before_mb": 60.0,
        "runs": [[4, 8.0, 0.5], [8, 16.0, 0.4]], "is_converged": True, "minimum": 0.4,
        "energies": {"spokes": 0.4, "spokes_and_rims": 0.2}, "near": {"iterations": 8, "ms": 16.0},
    } | more  # fmt: skip


PEERS = {
    "machine": MACHINE,
    "threads": 2,
    "budget_s": 60.0,
    "meshes": [
        {
            "mesh": "bar",
            "n_vertices": 1234,
            "rows": [
                {"library": "cgal", "not_run": "no CGAL here"},
                peer_row("ours", 2.0, isa="avx2", iteration_ms_of_rounds=[1.0, 2.0, 4.0]),
                peer_row("libigl", 30.0, iteration_ms_of_rounds=[20.0, 30.0, 40.0], near=None),
            ],
        }
    ],
}


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "-"), (0.0, "0"), (0.0123449, "0.0123"), (0.000999, "0.000999"), (0.9996, "1.00"),
        (5.206, "5.21"), (9.5959, "9.60"), (51.25, "51.2"), (999.6, "1000"),
        (1283.4, "1283"), (123456.7, "123457"), (-2.5, "-2.50"),
    ],
)  # fmt: skip
def test_numbers_have_three_digits_and_no_exponent(value, text):
    assert tables.number(value) == text


def test_the_ratio_is_the_median_of_the_rounds():
    text = tables_peers.peer_ratios(PEERS["meshes"][0]["rows"])
    assert "| libigl | spokes | 15.0 |" in text  # 20, 15, 10
    assert "AVX2" in text


def test_what_cannot_run_is_named_with_its_reason():
    assert "- Not run: CGAL: no CGAL here" in tables_peers.peers(PEERS)


def test_what_does_not_get_near_the_minimum_says_how_long_it_was_given():
    text = tables_peers.peers(PEERS)
    assert "| 60.0 | not in 0.0160 s | - |" in text
    assert "60 s for each library" in text


def test_a_minimum_that_is_not_the_library_s_own_is_marked():
    assert tables_peers.near_ms(peer_row("cgal", 2.0)) == "16.0"
    assert tables_peers.near_ms(peer_row("cgal", 2.0, is_converged=False)) == "16.0*"


def native_data(**descent):
    row = {
        "isa": "avx2", "energy": "spokes", "peak_mb": 50.0, "refactor_ms": 5.0, "bind_ms": 9.0, "local_ms": 1.0,
        "global_ms": 2.0, "solve_ms": 1.5, "factor_bytes": 1_500_000, "solve_gb_per_s": 20.0, "read_gb_per_s": 40.0,
    }  # fmt: skip
    return {
        "machine": MACHINE,
        "meshes": [
            {
                "mesh": "bar",
                "n_vertices": 1234,
                "dram_gb_per_s": [20.0, 30.0],
                "rows": [
                    {"isa": "avx512", "not_run": "the machine lacks it"},
                    row | {"threads": 1, "iteration_ms": 4.0, "once_ms": 0.5},
                    row | {"threads": 2, "iteration_ms": 3.0, "once_ms": 0.5},
                ],
                "descents": [
                    {
                        "energy": "spokes", "isa": "avx2", "threads": 2, "minimum": 0.5, "is_converged": True,
                        "near": {"1.1": {"iterations": 3, "ms": 9.0}, "1.01": None}, **descent,
                    }
                ],
            }
        ],
    }  # fmt: skip


def test_each_act_is_shown_on_the_best_number_of_threads():
    text = tables_native.native(native_data())
    assert (
        "| bar, 1234 | spokes | 2 | 9.00 | 5.00 | 1.00 | 2.00 | 3.00 | 0.500 | 9.00 | - | 20.0 | 40.0 | 50.0 |" in text
    )
    assert "| bar, 1234 | spokes | 4.00 | **3.00** | 2 |" in text
    assert "- Not run: AVX-512: the machine lacks it" in text
    assert "memory is read at 20.0, 30.0 GB/s by 1, 2, ... threads" in text


def test_times_to_a_minimum_that_was_not_reached_are_marked():
    assert "| 9.00* | - |" in tables_native.native(native_data(is_converged=False))


def test_a_section_is_replaced_between_its_markers_alone():
    document = "a\n<!-- measured: x -->\nold\n<!-- end of x -->\nb <!-- measured: y --><!-- end of y -->\n"
    new = replace_section(document, "x", r"new \1")
    assert new == document.replace("\nold\n", "\n\nnew \\1\n\n")
    assert replace_section(new, "x", r"new \1") == new


@pytest.mark.parametrize("document", ["", "<!-- measured: x -->", 2 * "<!-- measured: x --><!-- end of x -->"])
def test_a_document_without_the_section_is_refused(document):
    with pytest.raises(ValueError, match="must have one"):
        replace_section(document, "x", "new")


def test_sections_without_results_are_left_alone():
    assert sections({}, {}, {}) == {}
    assert list(sections({"native": native_data(), "frame": []}, {}, {})) == ["native"]


def quality_row(n_vertices, **more):
    return {
        "n_vertices": n_vertices, "energy": 0.5, "is_converged": True, "curvature": 1.5, "rms_deg": 3.0,
        "p99_deg": 20.0, "max_deg": 70.0, "sharp_edges": 2, "flips": 1, "near": [12, True],
    } | more  # fmt: skip


QUALITY = {
    "machine": MACHINE,
    "not_run": {"nodes": "no such energy"},
    "poses": {
        "bar_bend": {
            "mesh": "bar",
            "pose": "bend",
            "is_sample": True,
            "rows": {
                "plain": [
                    quality_row(100),
                    quality_row(400, moved=0.0123, near=[30, False], is_converged=False),
                    quality_row(1600, moved=0.02, near=None, walls={"passed": 0.1, "median": 0.75}),
                ]
            },
        },
        "bar_once": {
            "mesh": "bar",
            "pose": "bend in one step",
            "is_sample": True,
            "rows": {"plain": [quality_row(400, from_steps=0.002)]},
        },
    },
    "kinds": {},
    "drag": {},
    "symmetry": {},
}


def test_a_pose_has_a_line_for_each_density():
    text = tables_quality.sections(QUALITY)["quality-poses"]
    assert "| plain | 100 | 0.500 | 1.50 | 3.0 | 20 | 70 | 2 | 1 | 12 | - |" in text
    assert "| plain | 400 | 0.500* | 1.50 | 3.0 | 20 | 70 | 2 | 1 | 30* | 1.2 |" in text
    assert "| plain | 1600 | 0.500 | 1.50 | 3.0 | 20 | 70 | 2 | 1 | - | 2.0 |" in text
    assert "- Not run: rotation nodes: no such energy" in text
    assert "one step" not in text


def test_parts_that_were_not_measured_leave_their_sections_alone():
    found = tables_quality.sections(QUALITY)
    assert list(found) == ["quality-poses", "quality-walls", "quality-steps"]
