# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks that the modules in wheels run on every machine that the wheels' names promise.

Usage: check_wheel.py WHEEL...

Each links only to what every such system has, asks for no newer one, is signed where it must be, is small, names no
path of the machine that built it, and has the licences of what is linked into it. Needs llvm-readobj and llvm-nm.
Prints a line for each wheel; fails with one line for each fault.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path

from platforms import PLATFORMS, platform_of

LARGEST_WHEEL = 5_000_000
# What every system of its kind has. The C run-time library of Windows is a part of it since Windows 10.
LIBRARIES = {
    "windows": r"(?i)(kernel32|ntdll|api-ms-win-crt-[a-z0-9-]+|api-ms-win-core-synch-l1-2-0|python\d+)\.dll",
    "linux": r"(libc|libm|libpthread|libdl|librt|ld-linux-[a-z0-9-]+)\.so\.\d+",
    "macos": r"/usr/lib/libSystem\.B\.dylib|@rpath/_native\..*",  # the second is its own name
}
# Names of macOS's C library that modules use. Each is in macOS 11; look a new one up before it is added.
MACOS_NAMES = Path(__file__).with_name("macos_names.txt")
OF_PYTHON = re.compile(r"_?_?Py")
LINKED_IN = {"windows": ("mingw",), "linux": ("glibc",), "macos": ()}


def tool(name: str, *arguments: str | Path) -> str:
    """Output of a tool of LLVM."""
    path = shutil.which(name)
    if path is None:
        raise ValueError(f"there is no {name}: install LLVM (apt: llvm)")
    return subprocess.run([path, *arguments], capture_output=True, text=True, check=True).stdout  # noqa: S603


def needed_libraries(module: Path) -> list[str]:
    """The libraries that a module is linked to."""
    listed = re.search(r"NeededLibraries \[\n(.*?)\]", tool("llvm-readobj", "--needed-libs", module), re.DOTALL)
    return [line.strip() for line in listed[1].splitlines()] if listed else []


def linux_faults(module: Path, newest: tuple[int, int]) -> Iterator[str]:
    """Versions of glibc that are newer than the wheel's name says."""
    text = tool("llvm-readobj", "--version-info", module)
    for version in sorted(set(re.findall(r"GLIBC_(\d+\.\d+)", text))):
        if tuple(map(int, version.split("."))) > newest:
            yield f"asks for glibc {version}, but its name promises {'.'.join(map(str, newest))}"


def macos_faults(module: Path, oldest: str) -> Iterator[str]:
    """A newer system than the wheel's name says, names that it may lack, or no signature."""
    header = tool("llvm-objdump", "--macho", "--private-headers", module)
    minimum = re.search(r"minos (\S+)", header)
    if minimum is None or minimum[1] != oldest:
        yield f"asks for macOS {minimum[1] if minimum else 'unknown'}, but its name promises {oldest}"
    if "LC_CODE_SIGNATURE" not in header:
        yield "has no signature, without which macOS on ARM loads nothing"
    known = {line for line in MACOS_NAMES.read_text(encoding="utf-8").splitlines() if not line.startswith("#")}
    names = {line.split()[-1].removeprefix("_") for line in tool("llvm-nm", "-u", module).splitlines() if line.strip()}
    for name in sorted(name for name in names - known if not OF_PYTHON.match(name)):
        yield f"uses {name}: look up whether macOS {oldest} has it, and add it to {MACOS_NAMES.name}"


def module_faults(module: Path, wheel: Path) -> Iterator[str]:
    """What is wrong with a module."""
    platform = PLATFORMS[platform_of(wheel)]
    for library in needed_libraries(module):
        if not re.fullmatch(LIBRARIES[platform.system], library):
            yield f"links to {library}, which not every system has"
    version = re.search(r"_(\d+)_(\d+)_", platform.wheel_tag)
    if platform.system == "linux" and version:
        yield from linux_faults(module, (int(version[1]), int(version[2])))
    if platform.system == "macos" and version:
        yield from macos_faults(module, f"{version[1]}.{version[2]}")
    content = module.read_bytes()
    places = (str(Path(__file__).resolve().parents[1]), str(Path.home()) + "/", "site-packages")
    inside = [place for place in places if place.encode() in content]
    if inside:  # the first will do: the clone may be in the home
        yield f"has a path of the machine that built it inside: {inside[0]}"


def wheel_faults(wheel: Path) -> Iterator[str]:
    """What is wrong with a wheel."""
    if wheel.stat().st_size > LARGEST_WHEEL:
        yield f"has {wheel.stat().st_size} bytes, more than {LARGEST_WHEEL}"
    with zipfile.ZipFile(wheel) as archive, tempfile.TemporaryDirectory() as folder:
        names = archive.namelist()
        modules = [name for name in names if name.endswith((".so", ".pyd"))]
        if len(modules) != 1:
            yield f"holds {len(modules)} modules, must hold one"
        licences = " ".join(name for name in names if "/licenses/" in name)
        for part in ("libcxx", "libunwind", *LINKED_IN[PLATFORMS[platform_of(wheel)].system]):
            if part not in licences:
                yield f"lacks the licence of {part}, which is linked in"
        for name in modules:
            yield from module_faults(Path(archive.extract(name, folder)), wheel)


def main() -> int:
    """Command line."""
    n_faults = 0
    for wheel in map(Path, sys.argv[1:]):
        faults = list(wheel_faults(wheel))
        print(f"{wheel.name}: {wheel.stat().st_size / 1e6:.2f} MB, {'FAULTY' if faults else 'ok'}")
        for fault in faults:
            print(f"{wheel.name} {fault}", file=sys.stderr)
        n_faults += len(faults)
    return 1 if n_faults else 0


if __name__ == "__main__":
    sys.exit(main())
