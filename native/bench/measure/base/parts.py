# SPDX-License-Identifier: GPL-3.0-or-later
"""A run of several parts whose results are in one file: what is measured takes the place of what was there."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from . import machine


def measure_parts(out: Path, parts: Sequence[str], measures: Mapping[str, Callable[[], Any]]) -> None:
    """Measures these parts one after the other. ``out``, a JSON file, is written after each."""
    results: dict[str, Any] = json.loads(out.read_text()) if out.exists() else {}
    for part in parts:
        about = machine.description()
        results |= {part: measures[part](), "machine": about}
        out.write_text(json.dumps(results, indent=1))
