# SPDX-License-Identifier: GPL-3.0-or-later
"""Wheels that are written around a module for another platform."""

import zipfile

import build_wheel
import pytest
from platforms import PLATFORMS, platform_of

INFO = "arap_native-0.1.0.dist-info"


@pytest.fixture
def parts(tmp_path):
    """A module, metadata and a zig package, all stand-ins."""
    (tmp_path / "module").write_bytes(b"module")
    metadata = tmp_path / INFO
    (metadata / "licenses").mkdir(parents=True)
    (metadata / "METADATA").write_text("Name: arap-native\n")
    (metadata / "WHEEL").write_text("Tag: of the machine that builds\n")
    (metadata / "licenses" / "LICENSE").write_text("GPL")
    for name in (*build_wheel.LICENSES_OF_ALL, *sum(build_wheel.LICENSES.values(), ())):
        (tmp_path / "zig" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "zig" / name).write_text(name)
    return tmp_path


def files_for(parts, platform):
    return build_wheel.wheel_files(parts / "module", "cp313", PLATFORMS[platform], parts / INFO, parts / "zig")


def test_the_wheel_says_what_it_is_for_and_records_its_files(parts):
    files = files_for(parts, "windows-x64")
    assert files["arap_native/_native.cp313-win_amd64.pyd"] == b"module"
    assert b"Tag: cp313-cp313-win_amd64\n" in files[f"{INFO}/WHEEL"]
    record = files[f"{INFO}/RECORD"].decode().splitlines()
    assert [line.split(",")[0] for line in record] == list(files)
    assert f"{INFO}/RECORD,," in record


def test_it_has_the_licences_of_what_is_linked_in(parts):
    assert f"{INFO}/licenses/zig-lib-libc-mingw-COPYING" in files_for(parts, "windows-x64")
    files = files_for(parts, "macos-arm64")
    assert f"{INFO}/licenses/zig-lib-libcxx-LICENSE.TXT" in files
    assert not any("mingw" in name for name in files)


def test_the_same_files_give_the_same_bytes(parts):
    files = files_for(parts, "linux-arm64")
    first, second = (build_wheel.write_wheel(parts / name, files, "a.whl").read_bytes() for name in ("one", "two"))
    assert first == second


@pytest.mark.parametrize("platform", PLATFORMS)
def test_the_name_of_a_wheel_says_its_platform(tmp_path, platform):
    assert platform_of(tmp_path / f"a-1-cp313-cp313-{PLATFORMS[platform].wheel_tag}.whl") == platform


def test_a_wheel_can_be_read(parts):
    path = build_wheel.write_wheel(parts, files_for(parts, "linux-x64"), "a.whl")
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
        assert "arap_native/__init__.py" in archive.namelist()
