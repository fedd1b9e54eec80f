# SPDX-License-Identifier: GPL-3.0-or-later
"""The platforms that zips are made for."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Platform:
    """A platform by its name in Blender's extensions."""

    name: str
    zig_target: str  # with the oldest system that the modules run on
    wheel_tag: str  # which repeats that system
    suffix: str  # end of a module's file name, with {tag} and {version} of its Python

    @property
    def system(self) -> str:
        return self.name.split("-")[0]

    def module_name(self, tag: str) -> str:
        """File name of the module for a Python, given as cp313."""
        return "_native" + self.suffix.format(tag=tag, version=tag.removeprefix("cp"))


# As old as what Blender itself needs: glibc 2.28; macOS 11 is the first on ARM.
PLATFORMS = {
    platform.name: platform
    for platform in (
        Platform("windows-x64", "x86_64-windows-gnu", "win_amd64", ".{tag}-win_amd64.pyd"),
        Platform("windows-arm64", "aarch64-windows-gnu", "win_arm64", ".{tag}-win_arm64.pyd"),
        Platform(
            "linux-x64", "x86_64-linux-gnu.2.28", "manylinux_2_28_x86_64", ".cpython-{version}-x86_64-linux-gnu.so"
        ),
        Platform(
            "linux-arm64", "aarch64-linux-gnu.2.28", "manylinux_2_28_aarch64", ".cpython-{version}-aarch64-linux-gnu.so"
        ),
        Platform("macos-arm64", "aarch64-macos.11.0", "macosx_11_0_arm64", ".cpython-{version}-darwin.so"),
        Platform("macos-x64", "x86_64-macos.11.0", "macosx_11_0_x86_64", ".cpython-{version}-darwin.so"),
    )
}


def platform_of(wheel: Path) -> str:
    """Blender's name of a wheel's platform.

    Raises:
        ValueError: there is no Blender on it.
    """
    tag = wheel.stem.split("-")[-1]
    machine = "arm64" if tag.endswith(("arm64", "aarch64")) else "x64"
    for prefix, system in (("manylinux", "linux"), ("macosx", "macos"), ("win", "windows")):
        if tag.startswith(prefix) and not tag.endswith("universal2"):
            return f"{system}-{machine}"
    raise ValueError(f"{wheel.name}: no Blender runs on platform {tag}")
