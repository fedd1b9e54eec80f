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
PEERS = PROGRAMS / "peers"
CGAL_LIBRARY = PEERS / "libcgal_models.so"
BLENDER, BLENDER_PYTHON = "bpy==4.5.*", "3.11"


@functools.cache
def library_python(name: str, *groups: str) -> Path:
    """The Python that has a library from PyPI, which may need groups of .ci/setup; ours is there, too."""
    for group in groups:
        _run(".ci/setup", group)
    return Path(_run(".ci/venv", f"peer-{name}", PYTHON, name, "numpy", str(our_wheel(PYTHON))))


@functools.cache
def cgal_program() -> Path:
    """The program that runs CGAL, built."""
    _build_with_cgal("cgal_peer")
    return PEERS / "cgal_peer"


@functools.cache
def own_program() -> Path:
    """The program that runs the library without Python, and with other sparse solvers; built."""
    _run(".ci/setup", "native")
    _build("arap_worker")
    return PROGRAMS / "arap_worker"


@functools.cache
def cgal_library() -> Path:
    """What contenders/cgal.py loads, built."""
    _build_with_cgal("cgal_models")
    return CGAL_LIBRARY


@functools.cache
def blender_python() -> Path:
    """The Python that has Blender; ours is there, too."""
    _run(".ci/setup", "bpy")
    return Path(_run(".ci/venv", "peer-blender", BLENDER_PYTHON, BLENDER, str(our_wheel(BLENDER_PYTHON))))


@functools.cache
def our_wheel(python: str) -> Path:
    """The wheel of arap_native for a version of Python, built."""
    _run(".ci/setup", "native")
    return Path(_run(".ci/wheels", str(ROOT / "build" / "dist" / "wheels"), python))


def _build_with_cgal(target: str) -> None:
    _run(".ci/setup", "native", "peers")
    _build(target, "-DARAP_BUILD_PEERS=ON")


def _build(target: str, *options: str) -> None:
    _run("cmake", "--preset", "release", *options)
    _run("cmake", "--build", "--preset", "release", "-j2", "--target", target)


def _run(*command: str) -> str:
    """Output of a command; its last words are the reason where it fails."""
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        lines = (done.stderr.strip() or done.stdout.strip() or "failed").splitlines()
        raise NotRun(f"{command[0]}: {lines[-1]}")
    return done.stdout.strip()
