# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes measured results into Markdown documents between markers, and draws their pictures.

    python -m measure.pages.render RESULTS_DIR DOCS_DIR

RESULTS_DIR holds native, frame, together and peers.json for performance.md, and in window/VERSION drag-*.json and
overlay.json; quality.json, limbs.json and followers.json for quality.md, and compare.json and report.json for
comparison.md and its tables. A section without results stays as it is.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from itertools import chain
from pathlib import Path
from typing import Any

from . import compare, followers, limbs, native, peers, plots, quality, report
from .markdown import joined, replace_section

PICTURES = {
    "sizes": "Time of an iteration over the number of vertices, by instruction set",
    "peers": "Time of an iteration over the number of vertices, by library",
    "descent": "Energy over time from rest, by library",
}


def performance(folder: Path, images: Path) -> dict[str, str]:
    """The Markdown of each section of performance.md that has results; draws their pictures."""
    of_native, frame, together, of_peers = (
        read_json(folder / f"{name}.json") for name in ("native", "frame", "together", "peers")
    )
    drag, overlay = (
        [read_json(path) for path in sorted(folder.glob(f"window/*/{name}.json"))] for name in ("drag-*", "overlay")
    )
    found = {}
    if of_native:
        found["native"] = joined(native.native(of_native), picture("sizes"))
        plots.plot_native(of_native, images / "performance-sizes.svg")
    tables: dict[str, tuple[Callable[[Any], str], Any]] = {
        "frame": (native.frame, frame),
        "together": (native.together, together),
        "drag": (native.drag, drag),
        "overlay": (native.overlay, overlay),
    }
    found |= {name: table(results) for name, (table, results) in tables.items() if results}
    if of_peers:
        found["peers"] = joined(peers.peers(of_peers), picture("peers"), picture("descent"))
        plots.plot_peers(of_peers, images / "performance-peers.svg")
        plots.plot_descents(of_peers, images / "performance-descent.svg")
    return found


def picture(name: str) -> str:
    return f"![{PICTURES[name]}](images/performance-{name}.svg)"


def quality_sections(folder: Path, images: Path) -> dict[str, str]:
    """The same for quality.md, with the pictures that Blender rendered of the samples' poses and of kinds of meshes."""
    results = read_json(folder / "quality.json")
    if not results:
        return {}
    for name, entry in quality.shown(results["poses"]).items():
        rows = quality.panels(name, entry, folder / "quality")
        if rows and entry["is_sample"]:
            plots.plot_panels(rows, images / quality.picture_file(name))
    rows = quality.kind_panels(results["kinds"], folder / "quality")
    if rows:
        plots.plot_panels(rows, images / quality.KINDS_PICTURE)
    return quality.sections(results)


def limb_sections(folder: Path, images: Path) -> dict[str, str]:
    """The sections of quality.md about a solid beside a surface, with their pictures."""
    results = read_json(folder / "limbs.json")
    for mesh in limbs.PICTURES:
        rows = limbs.panels(results.get("limbs", {}), mesh, folder / "limbs")
        if rows:
            plots.plot_panels(rows, images / limbs.picture_file(mesh))
    return limbs.sections(results) if results else {}


def follower_sections(folder: Path, images: Path) -> dict[str, str]:
    """The sections of quality.md about what is worn, with their picture."""
    results = read_json(folder / "followers.json")
    rows = followers.panels(results.get("worn", []), folder / "followers")
    if rows:
        plots.plot_panels(rows, images / followers.PICTURE)
    return followers.sections(results) if results else {}


def comparison_sections(folder: Path, images: Path) -> tuple[dict[str, str], dict[str, str]]:
    """The sections of comparison.md, with its pictures, and of comparison-tables.md."""
    results, of_report = (read_json(folder / f"{name}.json") for name in ("compare", "report"))
    found = {"report": report.report(of_report)} if of_report else {}
    if not results:
        return found, {}
    rows = compare.panels(folder / "compare")
    if rows:
        plots.plot_panels(rows, images / compare.PICTURE, dpi=110)
    return found | compare.sections(results), compare.tables(results)


def read_json(path: Path) -> dict[str, Any]:
    return json.loads(path.read_text()) if path.exists() else {}


def write_sections(document: Path, bodies: dict[str, str]) -> None:
    text = document.read_text()
    for name, body in bodies.items():
        text = replace_section(text, name, body)
    document.write_text(text)
    print(f"{document}: {', '.join(bodies) or 'no results'}")


def main() -> None:
    folder, docs = map(Path, sys.argv[1:])
    images = docs / "images"
    images.mkdir(parents=True, exist_ok=True)
    write_sections(docs / "performance.md", performance(folder, images))
    of_quality = (part(folder, images) for part in (quality_sections, limb_sections, follower_sections))
    write_sections(docs / "quality.md", dict(chain.from_iterable(map(dict.items, of_quality))))
    comparison, tables = comparison_sections(folder, images)
    write_sections(docs / "comparison.md", comparison)
    write_sections(docs / "comparison-tables.md", tables)


if __name__ == "__main__":
    main()
