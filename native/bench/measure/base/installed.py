# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up what is measured: each Python library in an environment of its own, CGAL's program, our own program."""

from __future__ import annotations

import functools
import subprocess
from pathlib import Path

from .workers import NotRun

ROOT = Path(__file__).resolve().parents[4]
PYTHON = "3.13"
PROGRAMS = ROOT / "build" / "native" / "release" / "native" / "bench"


@functools.cache
def library_python(name: str, *groups: str) -> Path:
    """The Python that has a library from PyPI, which may need groups of .ci/setup."""
    for group in groups:
        _run(".ci/setup", group)
    return Path(_run(".ci/venv", f"peer-{name}", PYTHON, name, "numpy"))


@functools.cache
def cgal_program() -> Path:
    """The program that runs CGAL, built."""
    _run(".ci/setup", "native", "peers")
    _run("cmake", "--preset", "release", "-DARAP_BUILD_PEERS=ON")
    _run("cmake", "--build", "--preset", "release", "-j2", "--target", "cgal_peer")
    return PROGRAMS / "peers" / "cgal_peer"


def _run(*command: str) -> str:
    """Output of a command; its last words are the reason where it fails."""
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        lines = (done.stderr.strip() or done.stdout.strip() or "failed").splitlines()
        raise NotRun(f"{command[0]}: {lines[-1]}")
    return done.stdout.strip()
