# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a wheel of arap_native around a module that was compiled for another platform.

Usage: build_wheel.py --module FILE --python X.Y --platform NAME --metadata DIR --zig DIR --out DIR

The same files give the same bytes. Prints the path of the wheel.
"""

from __future__ import annotations

import argparse
import base64
import hashlib
import zipfile
from pathlib import Path

from platforms import PLATFORMS, Platform

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "native" / "bindings" / "arap_native"
# What zig links into a module, by platform: places of the licences in its package. All: itself and LLVM's libraries.
LICENSES_OF_ALL = ("LICENSE", "lib/libcxx/LICENSE.TXT", "lib/libcxxabi/LICENSE.TXT", "lib/libunwind/LICENSE.TXT")
LICENSES = {"windows": ("lib/libc/mingw/COPYING",), "linux": ("lib/libc/glibc/LICENSES",), "macos": ()}
ZIP_TIME = (1980, 1, 1, 0, 0, 0)


def record_line(name: str, content: bytes) -> str:
    """A file's line in RECORD."""
    digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(content)}\n"


def wheel_files(module: Path, tag: str, platform: Platform, metadata: Path, zig: Path) -> dict[str, bytes]:
    """The wheel's files by their names, RECORD last.

    Args:
        module: the compiled module
        tag: of its Python, as cp313
        platform: what it is compiled for
        metadata: a .dist-info folder, as scikit-build-core prepares it, with the licences of the project's own parts
        zig: the package that compiled it
    """
    info = metadata.name
    files = {f"arap_native/{path.name}": path.read_bytes() for path in PACKAGE.iterdir() if path.is_file()}
    files[f"arap_native/{platform.module_name(tag)}"] = module.read_bytes()
    for path in metadata.rglob("*"):
        if path.is_file() and path.name != "WHEEL":
            files[f"{info}/{path.relative_to(metadata).as_posix()}"] = path.read_bytes()
    for name in LICENSES_OF_ALL + LICENSES[platform.system]:
        files[f"{info}/licenses/zig-{name.replace('/', '-')}"] = (zig / name).read_bytes()
    wheel = (
        f"Wheel-Version: 1.0\nGenerator: arap_deform\nRoot-Is-Purelib: false\nTag: {tag}-{tag}-{platform.wheel_tag}\n"
    )
    files[f"{info}/WHEEL"] = wheel.encode()
    files = dict(sorted(files.items()))
    record = "".join(record_line(name, content) for name, content in files.items()) + f"{info}/RECORD,,\n"
    return {**files, f"{info}/RECORD": record.encode()}


def write_wheel(out: Path, files: dict[str, bytes], name: str) -> Path:
    """Writes the files into a wheel with one fixed time."""
    out.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(out / name, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for file, content in files.items():
            info = zipfile.ZipInfo(file, ZIP_TIME)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.create_system = 3
            info.external_attr = (0o755 if file.endswith((".so", ".pyd")) else 0o644) << 16
            archive.writestr(info, content)
    return out / name


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description="Writes a wheel of arap_native around a compiled module.")
    parser.add_argument("--module", type=Path, required=True, help="the compiled module")
    parser.add_argument("--python", required=True, help="version of its Python, as 3.13")
    parser.add_argument("--platform", choices=list(PLATFORMS), required=True)
    parser.add_argument("--metadata", type=Path, required=True, help="the .dist-info folder")
    parser.add_argument("--zig", type=Path, required=True, help="the package ziglang that compiled it")
    parser.add_argument("--out", type=Path, required=True, help="folder that takes the wheel")
    given = parser.parse_args()
    tag, platform = "cp" + given.python.replace(".", ""), PLATFORMS[given.platform]
    files = wheel_files(given.module, tag, platform, given.metadata, given.zig)
    name = f"{given.metadata.name.removesuffix('.dist-info')}-{tag}-{tag}-{platform.wheel_tag}.whl"
    print(write_wheel(given.out, files, name))


if __name__ == "__main__":
    main()
