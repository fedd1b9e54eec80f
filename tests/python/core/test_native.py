# SPDX-License-Identifier: GPL-3.0-or-later
"""Loading the native module, and the reason if that fails."""

import re
import sys
import types
from pathlib import Path

import pytest
from arap_deform.core import native
from platforms import PLATFORMS

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The one folder of modules there is; no arap_native is loaded yet, and what a test loads is forgotten."""
    for name in [name for name in sys.modules if name.split(".")[0] == native.MODULE]:
        monkeypatch.delitem(sys.modules, name)
    before = set(sys.modules)
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    yield tmp_path
    for name in set(sys.modules) - before:
        if name.split(".")[0] == native.MODULE:
            del sys.modules[name]


HERE = r"Python \S+ on \S+ \S+"


def refusal():
    """Why no module is loaded."""
    with pytest.raises(RuntimeError) as error:
        native._load()
    return str(error.value)


def put_module(folder, text):
    package = folder / native.MODULE
    package.mkdir()
    (package / "__init__.py").write_text(text)
    return package


def test_version_is_the_projects():
    match = re.search(r"project\(arap VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())
    assert match[1] == native.VERSION


def test_the_installed_module_is_found():
    assert native.problem() == ""
    assert native.load().__version__ == native.VERSION


def test_a_missing_module_is_named(folder):
    remedy = rf"install arap_deform-{native.VERSION}-\w+-\w+\.zip"
    assert re.fullmatch(f"The solver module is missing for {HERE}: {remedy}", refusal())


@pytest.mark.parametrize(
    ("system", "machine", "remedy"),
    [
        ("Windows", "AMD64", f"install arap_deform-{native.VERSION}-windows-x64.zip"),
        ("Darwin", "arm64", f"install arap_deform-{native.VERSION}-macos-arm64.zip"),
        ("Linux", "aarch64", f"install arap_deform-{native.VERSION}-linux-arm64.zip"),
        ("Darwin", "x86_64", "no zip is made for macos-x64; build one from the source with make zip"),
        ("FreeBSD", "amd64", "no zip is made for FreeBSD-amd64; build one from the source with make zip"),
    ],
)
def test_on_the_wrong_system_the_right_zip_is_named(folder, monkeypatch, system, machine, remedy):
    monkeypatch.setattr(native.platform, "system", lambda: system)
    monkeypatch.setattr(native.platform, "machine", lambda: machine)
    assert refusal().endswith(f": {remedy}")


def test_every_platform_that_is_named_has_its_zip():
    assert set(native.PLATFORMS) <= set(PLATFORMS)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("import a_library_that_is_not_there\n", "No module named 'a_library_that_is_not_there'"),
        ("raise ImportError('GLIBC_2.99 not\\nfound')\n", "GLIBC_2.99 not found"),
    ],
)
def test_a_module_that_the_system_cannot_load_gives_its_reason(folder, text, reason):
    put_module(folder, text)
    pattern = rf"The solver module in its wheel cannot be loaded by {HERE} \({re.escape(reason)}\): \S.*"
    assert re.fullmatch(pattern, refusal())
    assert native.MODULE not in sys.modules


def test_an_old_module_in_memory_asks_for_a_restart(folder, monkeypatch):
    old = types.ModuleType(native.MODULE)
    old.__version__ = "0.0.1"
    old.__file__ = "old.so"
    monkeypatch.setitem(sys.modules, native.MODULE, old)
    assert refusal() == (
        f"ARAP Deform is {native.VERSION}, but Blender still runs solver module 0.0.1 (old.so): "
        "save your work and restart Blender"
    )


def test_an_old_module_on_disk_asks_for_a_new_installation(folder):
    package = put_module(folder, "__version__ = '0.0.1'\n")
    assert refusal() == (
        f"ARAP Deform is {native.VERSION}, but the installed solver module is 0.0.1 ({package / '__init__.py'}): "
        "remove the add-on and install its zip again"
    )
    assert native.MODULE not in sys.modules


def test_load_raises_what_problem_says(monkeypatch):
    monkeypatch.setattr(native, "_problem", "because")
    with pytest.raises(RuntimeError, match=r"^because$"):
        native.load()
