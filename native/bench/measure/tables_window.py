# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of measurements in windows of Blender: drags, and the overlay."""

from __future__ import annotations

from collections.abc import Sequence

from .tables import Row, joined, medians

ACTS = {"pose": "Pose", "pull": "ARAP Pull", "blend": "Blend"}


def drag(results: Sequence[Row]) -> str:
    """Cost of a frame of a drag, medians in milliseconds: a table for each Blender, a column an act and size."""
    blenders = dict.fromkeys(r["blender"] for r in results)
    return joined(*(_of_blender(blender, [r for r in results if r["blender"] == blender]) for blender in blenders))


def overlay(results: Sequence[Row]) -> str:
    """Cost of a redraw with the overlay, medians in milliseconds: a column a Blender."""
    if not results:
        return ""
    return medians([f"Blender {r['blender']}" for r in results], results)


def _of_blender(blender: str, results: list[Row]) -> str:
    results.sort(key=lambda r: (list(ACTS).index(r["act"]), r["vertices"]))
    return joined(f"### Blender {blender}", medians([f"{ACTS[r['act']]}, {r['vertices']}" for r in results], results))
