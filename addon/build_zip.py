# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs the add-on: a legacy zip for Blender below 4.2 and an extension zip for 4.2 and later.

Usage: build_zip.py --wheels DIR --out DIR [--only legacy|extension] [--release]

--release: an extension zip for each platform, named by it, in place of one for all.

The same tree and the same wheels give the same bytes. Prints the paths of the zips.
"""

from __future__ import annotations

import argparse
import ast
import io
import re
import sys
import zipfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from platforms import PLATFORMS, platform_of

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "addon" / "arap_deform"
MANIFEST = "blender_manifest.toml"
# Official Blender: 3.4 to 4.0 run Python 3.10, 4.1 to 5.0 run 3.11, 5.1 and later 3.13; Debian's 3.4 runs 3.11.
LEGACY_PYTHONS = ("cp310", "cp311")
EXTENSION_PYTHONS = ("cp311", "cp312", "cp313", "cp314")
ZIP_TIME = (1980, 1, 1, 0, 0, 0)

Files = dict[str, bytes]


def project_version() -> str:
    """The version in CMakeLists.txt, which all other places repeat."""
    match = re.search(r"project\(arap VERSION (\d+\.\d+\.\d+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))
    if match is None:
        raise ValueError("CMakeLists.txt has no line 'project(arap VERSION x.y.z ...)'")
    return match[1]


def bl_info_node(source: str) -> ast.Assign:
    """The assignment of bl_info in the add-on's __init__.py."""
    for node in ast.parse(source).body:
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == "bl_info" for t in node.targets):
            return node
    raise ValueError("arap_deform/__init__.py has no bl_info")


def without_bl_info(source: str) -> str:
    """The source without bl_info: Blender warns about it in an extension."""
    node = bl_info_node(source)
    lines = source.splitlines(keepends=True)
    before, after = lines[: node.lineno - 1], lines[node.end_lineno :]
    while after and not after[0].strip() and before and not before[-1].strip():
        del after[0]
    return "".join(before + after)


def check_versions(version: str, init: str, manifest: str) -> None:
    """Raises ValueError if bl_info or the manifest state another version than CMakeLists.txt."""
    bl_info = ast.literal_eval(bl_info_node(init).value)
    stated = {
        "bl_info in arap_deform/__init__.py": ".".join(str(number) for number in bl_info["version"]),
        MANIFEST: (re.findall(r'^version\s*=\s*"([^"]*)"', manifest, re.MULTILINE) or ["none"])[0],
    }
    for place, other in stated.items():
        if other != version:
            raise ValueError(f"{place} states version {other}, CMakeLists.txt {version}: make them equal")


def addon_files() -> Files:
    """The add-on's own files by path in the package."""
    files = {
        path.relative_to(SOURCE).as_posix(): path.read_bytes()
        for path in SOURCE.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts and not path.name.startswith(".")
    }
    return {**files, "LICENSE": (ROOT / "LICENSE").read_bytes()}


def wheels_for(wheels_dir: Path, pythons: Iterable[str], version: str) -> dict[str, list[Path]]:
    """The wheels of this version by Python tag; several platforms give several wheels."""
    found = {tag: sorted(wheels_dir.glob(f"arap_native-{version}-{tag}-{tag}-*.whl")) for tag in pythons}
    found = {tag: wheels for tag, wheels in found.items() if wheels}
    if not found:
        raise ValueError(
            f"{wheels_dir} holds no wheel arap_native-{version} for any of {', '.join(pythons)}: run make wheel"
        )
    for wheels in found.values():
        for wheel in wheels:
            if "-linux_" in wheel.name:
                raise ValueError(f"{wheel.name} runs on this machine only: take one that auditwheel repaired")
    return found


def manifest_with_wheels(manifest: str, wheels: Iterable[Path]) -> str:
    """The manifest with the wheels and platforms of this build, placed before its first table."""
    names = [wheel.name for wheel in wheels]
    platforms = sorted({platform_of(wheel) for wheel in wheels})
    lines = ["platforms = [" + ", ".join(f'"{platform}"' for platform in platforms) + "]", "wheels = ["]
    lines += [f'  "./wheels/{name}",' for name in names]
    lines += ["]", "", ""]
    first_table = re.search(r"^\[", manifest, re.MULTILINE)
    at = first_table.start() if first_table else len(manifest)
    return manifest[:at].rstrip("\n") + "\n" + "\n".join(lines) + manifest[at:]


def extension_files(files: Files, wheels: Mapping[str, list[Path]]) -> Files:
    """What the extension zip holds: no bl_info, the wheels as they are."""
    every_wheel = [wheel for per_python in wheels.values() for wheel in per_python]
    init, manifest = files["__init__.py"].decode(), files[MANIFEST].decode()
    return {
        **files,
        "__init__.py": without_bl_info(init).encode(),
        MANIFEST: manifest_with_wheels(manifest, every_wheel).encode(),
        **{f"wheels/{wheel.name}": wheel.read_bytes() for wheel in every_wheel},
    }


def unpacked(wheel: Path) -> Files:
    """The files in a wheel, without the list that only an installer reads."""
    with zipfile.ZipFile(io.BytesIO(wheel.read_bytes())) as archive:
        names = [name for name in archive.namelist() if not name.endswith(("/", ".dist-info/RECORD"))]
        return {name: archive.read(name) for name in names}


def legacy_files(files: Files, wheels: Mapping[str, list[Path]]) -> Files:
    """What the legacy zip holds: no manifest, the wheels unpacked by Python version inside the package."""
    packed = {name: content for name, content in files.items() if name != MANIFEST}
    for tag, wheels_of_tag in wheels.items():
        for wheel in wheels_of_tag:
            for name, content in unpacked(wheel).items():
                path = f"native_modules/{tag}/{name}"
                if packed.get(path, content) != content and ".dist-info/" not in name:
                    raise ValueError(
                        f"{wheel.name} and a wheel of another platform both bring {name}: pack one of them"
                    )
                packed[path] = content
    return {f"arap_deform/{name}": content for name, content in packed.items()}


def write_zip(path: Path, files: Files) -> None:
    """Writes the files in the order of their names, with one fixed time."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, content in sorted(files.items()):
            info = zipfile.ZipInfo(name, ZIP_TIME)
            info.compress_type = zipfile.ZIP_STORED if name.endswith(".whl") else zipfile.ZIP_DEFLATED
            info.create_system = 3
            info.external_attr = (0o755 if ".so" in name or name.endswith(".pyd") else 0o644) << 16
            archive.writestr(info, content)


def by_platform(wheels: Mapping[str, list[Path]]) -> dict[str, dict[str, list[Path]]]:
    """The wheels of each platform, by Python tag."""
    split: dict[str, dict[str, list[Path]]] = {}
    for tag, of_tag in wheels.items():
        for wheel in of_tag:
            split.setdefault(platform_of(wheel), {}).setdefault(tag, []).append(wheel)
    return {platform: split[platform] for platform in PLATFORMS if platform in split}


def build(wheels_dir: Path, out: Path, kinds: Iterable[str], *, is_release: bool = False) -> list[Path]:
    """Writes the zips into ``out`` and returns their paths.

    In a release the extension has a zip for each platform.

    A zip may lack wheels of some Python versions, but not all: a machine builds wheels for the Pythons it has.
    """
    version = project_version()
    files = addon_files()
    check_versions(version, files["__init__.py"].decode(), files[MANIFEST].decode())
    zips = []
    for kind in kinds:
        pack, pythons = KINDS[kind]
        wheels = wheels_for(wheels_dir, pythons, version)
        parts = by_platform(wheels) if is_release and kind == "extension" else {kind: wheels}
        for name, some in parts.items():
            zips.append(out / f"arap_deform-{version}-{name}.zip")
            write_zip(zips[-1], pack(files, some))
    return zips


KINDS: dict[str, tuple[Callable[[Files, Mapping[str, list[Path]]], Files], tuple[str, ...]]] = {
    "legacy": (legacy_files, LEGACY_PYTHONS),
    "extension": (extension_files, EXTENSION_PYTHONS),
}


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description="Packs the add-on: a legacy zip and an extension zip.")
    parser.add_argument("--wheels", type=Path, required=True, help="folder with the repaired wheels of arap_native")
    parser.add_argument("--out", type=Path, required=True, help="folder that takes the zips")
    parser.add_argument("--only", choices=list(KINDS), help="one of the two zips; default: both")
    parser.add_argument("--release", action="store_true", help="an extension zip for each platform")
    arguments = parser.parse_args()
    try:
        kinds = [arguments.only] if arguments.only else list(KINDS)
        zips = build(arguments.wheels, arguments.out, kinds, is_release=arguments.release)
    except (OSError, ValueError) as error:
        print(f"build_zip: {error}", file=sys.stderr)
        return 1
    for path in zips:
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
