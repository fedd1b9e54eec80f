# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes measured results into Markdown documents, between their markers, and pictures beside them.

    python -m measure.render RESULTS_DIR DOCS_DIR

RESULTS_DIR holds results.json (native, frame, drag and overlay), peers.json and report.json for performance.md, and
quality.json for quality.md. A section of a document stands between <!-- measured: NAME --> and <!-- end of NAME -->;
one whose results are not there stays as it is.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

from . import tables_native, tables_peers, tables_quality, tables_report, tables_window
from .tables import joined

PICTURES = {
    "sizes": "Time of an iteration over the number of vertices, by instruction set",
    "peers": "Time of an iteration over the number of vertices, by library",
    "descent": "Energy over time from rest, by library",
}


def replace_section(document: str, name: str, body: str) -> str:
    """The document with what is between the markers of a section replaced.

    Raises:
        ValueError: the document does not have the two markers exactly once.
    """
    begin, end = f"<!-- measured: {name} -->", f"<!-- end of {name} -->"
    found, n = re.subn(
        re.escape(begin) + ".*?" + re.escape(end),
        lambda _: f"{begin}\n\n{body.strip()}\n\n{end}",
        document,
        flags=re.DOTALL,
    )
    if n != 1:
        raise ValueError(f"the document has {n} sections {begin} ... {end}, must have one")
    return found


def sections(results: dict[str, Any], peers: dict[str, Any], report: dict[str, Any]) -> dict[str, str]:
    """The Markdown of each section that there are results for."""
    found = {}
    if "native" in results:
        found["native"] = joined(tables_native.native(results["native"]), picture("sizes"))
    if results.get("frame"):
        found["frame"] = tables_native.frame(results["frame"])
    if results.get("drag"):
        found["drag"] = tables_window.drag(results["drag"])
    if results.get("overlay"):
        found["overlay"] = tables_window.overlay(results["overlay"])
    if peers:
        found["peers"] = joined(tables_peers.peers(peers), picture("peers"), picture("descent"))
    if report:
        found["report"] = tables_report.report(report)
    return found


def picture(name: str) -> str:
    return f"![{PICTURES[name]}](images/performance-{name}.svg)"


def draw(results: dict[str, Any], peers: dict[str, Any], images: Path) -> None:
    from . import plots  # noqa: PLC0415 - needs matplotlib, which the tables do without

    images.mkdir(parents=True, exist_ok=True)
    if "native" in results:
        plots.plot_native(results["native"], images / "performance-sizes.svg")
    if peers:
        plots.plot_peers(peers, images / "performance-peers.svg")
        plots.plot_descents(peers, images / "performance-descent.svg")


def read_json(path: Path) -> dict[str, Any]:
    return json.loads(path.read_text()) if path.exists() else {}


def draw_quality(quality: dict[str, Any], folder: Path, images: Path) -> None:
    """The pictures that Blender rendered of the samples' poses and of the kinds of meshes."""
    from . import plots  # noqa: PLC0415 - needs matplotlib, which the tables do without

    for name, entry in quality["poses"].items():
        rows = tables_quality.panels(name, entry, folder)
        if rows and entry["is_sample"]:
            plots.plot_panels(rows, images / tables_quality.picture_file(name))
    rows = tables_quality.kind_panels(quality["kinds"], folder)
    if rows:
        plots.plot_panels(rows, images / tables_quality.KINDS_PICTURE)


def write_sections(document: Path, bodies: dict[str, str]) -> None:
    text = document.read_text()
    for name, body in bodies.items():
        text = replace_section(text, name, body)
    document.write_text(text)
    print(f"{document}: {', '.join(bodies) or 'no results'}")


def main() -> None:
    folder, docs = map(Path, sys.argv[1:])
    names = ("results", "peers", "report", "quality")
    results, peers, report, quality = (read_json(folder / f"{name}.json") for name in names)
    images = docs / "images"
    write_sections(docs / "performance.md", sections(results, peers, report))
    draw(results, peers, images)
    write_sections(docs / "quality.md", tables_quality.sections(quality) if quality else {})
    if quality:
        draw_quality(quality, folder / "quality", images)


if __name__ == "__main__":
    main()
