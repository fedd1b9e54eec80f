# SPDX-License-Identifier: GPL-3.0-or-later
"""Which parts of the mesh nothing holds, in words."""

from __future__ import annotations

from ..core.session_data import SolveStats


def free_parts_text(stats: SolveStats) -> str:
    """One sentence on the parts and loose vertices that have no pin or handle."""
    counts = ((stats.parts_at_rest, "part", "parts"), (stats.loose_vertices, "loose vertex", "loose vertices"))
    found = [f"{n} {one if n == 1 else many}" for n, one, many in counts if n]
    is_one = stats.parts_at_rest + stats.loose_vertices == 1
    verbs = ("has", "does") if is_one else ("have", "do")
    return "{} {} no pin or handle and {} not move".format(" and ".join(found), *verbs)
