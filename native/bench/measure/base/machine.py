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
ISA_NAMES = {"baseline": "baseline", "avx2": "AVX2", "avx512": "AVX-512"}


def description() -> dict[str, object]:
    """Processor, cores, memory, the load before the measurement, and the day."""
    memory = re.search(r"MemTotal:\s+(\d+)", _text("/proc/meminfo"))
    model = re.search(r"model name\s*:\s*(.*)", _text("/proc/cpuinfo"))
    return {
        "processor": model[1] if model else platform.machine(),
        "cores": os.cpu_count(),
        "memory_gib": round(int(memory[1]) / 2**20) if memory else None,
        "load": round(os.getloadavg()[0], 2),
        "day": time.strftime("%Y-%m-%d"),
    }


def instruction_sets(bind: Callable[[str], None]) -> tuple[list[str], dict[str, str]]:
    """The values of ARAP_ISA that the library runs with, the fastest last, and why it does not with the others.

    ``bind`` binds anything in a process whose ARAP_ISA is the given value, and raises NotRun if that fails.
    """
    available: list[str] = []
    reasons: dict[str, str] = {}
    for isa in ISAS:
        try:
            bind(isa)
            available.append(isa)
        except NotRun as reason:
            reasons[isa] = str(reason)
    return available, reasons


def process_memory(name: str) -> int:
    """Bytes of this process, VmRSS now or VmHWM at most; getrusage would count what was its parent's before exec."""
    found = re.search(name + r":\s+(\d+) kB", _text("/proc/self/status"))
    return 1024 * int(found[1]) if found else 0


def _text(path: str) -> str:
    return Path(path).read_text() if Path(path).exists() else ""
