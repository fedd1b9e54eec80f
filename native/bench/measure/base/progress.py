# SPDX-License-Identifier: GPL-3.0-or-later
"""What a long run says while it goes on."""

from __future__ import annotations

import sys
import time
from typing import Any

STARTED = time.monotonic()


def say(what: str, row: dict[str, Any]) -> None:
    """Minutes since the start, what was measured, and its figures."""
    figures = {key: round(value, 4) if isinstance(value, float) else value for key, value in row.items()}
    print(f"{(time.monotonic() - STARTED) / 60:.1f} min: {what}: {figures}", file=sys.stderr, flush=True)
