# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs the add-on: an extension zip for each platform that there are wheels for, named by it.

Usage: build_zip.py --wheels DIR --out DIR

The same tree and the same wheels give the same bytes. Prints the paths of the zips.
"""

from __future__ import annotations

import argparse
import re
import sys
import zipfile
from collections.abc import Iterable
from pathlib import Path

from platforms import PLATFORMS, platform_of

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "addon" / "arap_deform"
MANIFEST = "blender_manifest.toml"
# Official Blender: 4.2 to 5.0 run Python 3.11, 5.1 and later 3.13, as Debian 13's does.
PYTHONS = ("cp311", "cp312", "cp313", "cp314")
ZIP_TIME = (1980, 1, 1, 0, 0, 0)

Files = dict[str, bytes]


def project_version() -> str:
    """The version in CMakeLists.txt, which all other places repeat."""
    match = re.search(r"project\(arap VERSION (\d+\.\d+\.\d+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))
    if match is None:
        raise ValueError("CMakeLists.txt has no line 'project(arap VERSION x.y.z ...)'")
    return match[1]


def check_version(version: str, manifest: str) -> None:
    """Raises ValueError if the manifest states another version than CMakeLists.txt."""
    stated = (re.findall(r'^version\s*=\s*"([^"]*)"', manifest, re.MULTILINE) or ["none"])[0]
    if stated != version:
        raise ValueError(f"{MANIFEST} states version {stated}, CMakeLists.txt {version}: make them equal")


def addon_files() -> Files:
    """The add-on's own files by path in the package."""
    files = {
        path.relative_to(SOURCE).as_posix(): path.read_bytes()
        for path in SOURCE.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts and not path.name.startswith(".")
    }
    return {**files, "LICENSE": (ROOT / "LICENSE").read_bytes()}


def wheels_by_platform(wheels_dir: Path, version: str) -> dict[str, list[Path]]:
    """The wheels of this version for Blender's Pythons."""
    names = [f"arap_native-{version}-{tag}-{tag}-*.whl" for tag in PYTHONS]
    wheels = [wheel for name in names for wheel in sorted(wheels_dir.glob(name))]
    if not wheels:
        raise ValueError(
            f"{wheels_dir} holds no wheel arap_native-{version} for any of {', '.join(PYTHONS)}: run make wheel"
        )
    found: dict[str, list[Path]] = {}
    for wheel in wheels:
        if "-linux_" in wheel.name:
            raise ValueError(f"{wheel.name} runs on this machine only: take one that auditwheel repaired")
        found.setdefault(platform_of(wheel), []).append(wheel)
    return {platform: found[platform] for platform in PLATFORMS if platform in found}


def manifest_with_wheels(manifest: str, platform: str, wheels: Iterable[Path]) -> str:
    """The manifest with the wheels and the platform of this build, placed before its first table."""
    lines = [f'platforms = ["{platform}"]', "wheels = [", *(f'  "./wheels/{wheel.name}",' for wheel in wheels), "]"]
    first_table = re.search(r"^\[", manifest, re.MULTILINE)
    at = first_table.start() if first_table else len(manifest)
    return manifest[:at].rstrip("\n") + "\n" + "\n".join([*lines, "", ""]) + manifest[at:]


def zip_files(files: Files, platform: str, wheels: Iterable[Path]) -> Files:
    """What the zip of a platform holds."""
    return {
        **files,
        MANIFEST: manifest_with_wheels(files[MANIFEST].decode(), platform, wheels).encode(),
        **{f"wheels/{wheel.name}": wheel.read_bytes() for wheel in wheels},
    }


def write_zip(path: Path, files: Files) -> None:
    """Writes the files in the order of their names, with one fixed time."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, content in sorted(files.items()):
            info = zipfile.ZipInfo(name, ZIP_TIME)
            info.compress_type = zipfile.ZIP_STORED if name.endswith(".whl") else zipfile.ZIP_DEFLATED
            info.create_system = 3
            info.external_attr = 0o644 << 16
            archive.writestr(info, content)


def build(wheels_dir: Path, out: Path) -> list[Path]:
    """Writes the zips into ``out`` and returns their paths.

    A zip may lack wheels of some Python versions: a machine builds wheels for the Pythons it has.
    """
    version = project_version()
    files = addon_files()
    check_version(version, files[MANIFEST].decode())
    zips = []
    for platform, wheels in wheels_by_platform(wheels_dir, version).items():
        zips.append(out / f"arap_deform-{version}-{platform}.zip")
        write_zip(zips[-1], zip_files(files, platform, wheels))
    return zips


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description="Packs the add-on: an extension zip for each platform.")
    parser.add_argument("--wheels", type=Path, required=True, help="folder with the repaired wheels of arap_native")
    parser.add_argument("--out", type=Path, required=True, help="folder that takes the zips")
    arguments = parser.parse_args()
    try:
        zips = build(arguments.wheels, arguments.out)
    except (OSError, ValueError) as error:
        print(f"build_zip: {error}", file=sys.stderr)
        return 1
    for path in zips:
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
