# SPDX-License-Identifier: GPL-3.0-or-later
"""What the figures were measured on, and which of the instruction sets it has."""

from __future__ import annotations

import os
import platform
import re
import time
from collections.abc import Callable
from pathlib import Path

from .workers import NotRun

ISAS = ("baseline", "avx2", "avx512")
ISA_NAMES = {"baseline": "baseline", "avx2": "AVX2", "avx512": "AVX-512", "": "compiled in"}


def description() -> dict[str, object]:
    """Processor, cores, memory, system, the load before the measurement, and the day."""
    memory = re.search(r"MemTotal:\s+(\d+)", _text("/proc/meminfo"))
    model = re.search(r"model name\s*:\s*(.*)", _text("/proc/cpuinfo"))
    return {
        "processor": model[1] if model else platform.machine(),
        "cores": os.cpu_count(),
        "memory_gib": round(int(memory[1]) / 2**20) if memory else None,
        "system": platform.system(),
        "load": round(os.getloadavg()[0], 2),
        "day": time.strftime("%Y-%m-%d"),
    }


def instruction_sets(bind: Callable[[str], None]) -> tuple[list[str], dict[str, str]]:
    """The values of ARAP_ISA that a library runs with, the fastest last, and why it does not with the others.

    A library that takes any value has no choice of its own: its one instruction set is named "".

    Args:
        bind: binds anything in a process whose ARAP_ISA is the given value; raises NotRun where that fails.
    """
    if _reason_against(bind, "none-such") is None:
        return [""], {}
    reasons = {isa: _reason_against(bind, isa) for isa in ISAS}
    available = [isa for isa, reason in reasons.items() if reason is None]
    return available, {isa: reason for isa, reason in reasons.items() if reason is not None}


def _reason_against(bind: Callable[[str], None], isa: str) -> str | None:
    try:
        bind(isa)
    except NotRun as reason:
        return str(reason)
    return None


def _text(path: str) -> str:
    return Path(path).read_text() if Path(path).exists() else ""
