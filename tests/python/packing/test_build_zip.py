# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on's zips hold. The wheels are stand-ins; the real ones are tested as installed zips."""

import re
import shutil
import zipfile
from pathlib import Path

import build_zip
import pytest

VERSION = build_zip.project_version()
LINUX = "manylinux_2_34_x86_64"


@pytest.fixture
def wheels(tmp_path):
    """A function that puts stand-in wheels into a folder and returns it."""
    folder = tmp_path / "wheels"
    folder.mkdir()

    def make(*tags, platform=LINUX):
        for tag in tags:
            (folder / f"arap_native-{VERSION}-{tag}-{tag}-{platform}.whl").write_bytes(b"wheel")
        return folder

    return make


def contents(path):
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_a_zip_holds_the_wheels_and_names_them(wheels, tmp_path):
    files = contents(build_zip.build(wheels("cp310", "cp311", "cp313"), tmp_path)[0])
    manifest = files["blender_manifest.toml"].decode()
    names = {f"wheels/arap_native-{VERSION}-{tag}-{tag}-{LINUX}.whl" for tag in ("cp311", "cp313")}
    assert {name for name in files if name.startswith("wheels/")} == names
    assert set(re.findall(r'"\./(wheels/[^"]+)"', manifest)) == names
    assert 'platforms = ["linux-x64"]' in manifest


def test_wheels_come_in_front_of_the_manifests_first_table():
    wheels = [Path(f"x-{LINUX}.whl")]
    manifest = build_zip.manifest_with_wheels('id = "x"\n\n[permissions]\nfiles = "y"\n', "linux-x64", wheels)
    assert manifest.splitlines() == [
        'id = "x"',
        'platforms = ["linux-x64"]',
        "wheels = [",
        f'  "./wheels/x-{LINUX}.whl",',
        "]",
        "",
        "[permissions]",
        'files = "y"',
    ]


def test_a_zip_holds_the_add_on_and_the_licence_and_nothing_else(wheels, tmp_path):
    files = contents(build_zip.build(wheels("cp311"), tmp_path)[0])
    for name in ("__init__.py", "api.py"):
        assert files[name] == (build_zip.SOURCE / name).read_bytes()
    assert files["LICENSE"] == (build_zip.ROOT / "LICENSE").read_bytes()
    assert not [name for name in files if "__pycache__" in name or "/." in name or name.startswith(".")]


def test_same_input_gives_the_same_bytes(wheels, tmp_path):
    folder = wheels("cp311", "cp313")
    first, second = build_zip.build(folder, tmp_path / "a"), build_zip.build(folder, tmp_path / "b")
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]


@pytest.mark.parametrize(
    ("tag", "platform", "message"),
    [
        ("cp311", "musllinux_1_2_x86_64", "no Blender runs on platform musllinux_1_2_x86_64"),
        ("cp310", LINUX, r"holds no wheel arap_native-\S+ for any of cp311, cp312, cp313, cp314: run make wheel"),
        ("cp311", "linux_x86_64", "runs on this machine only: take one that auditwheel repaired"),
    ],
)
def test_refuses_wheels_that_no_blender_can_use(wheels, tmp_path, tag, platform, message):
    with pytest.raises(ValueError, match=message):
        build_zip.build(wheels(tag, platform=platform), tmp_path)


@pytest.fixture
def copied_source(tmp_path, monkeypatch):
    """A copy of the add-on and of CMakeLists.txt that a test may spoil."""
    shutil.copytree(build_zip.SOURCE, tmp_path / "addon" / "arap_deform")
    for name in ("CMakeLists.txt", "LICENSE"):
        shutil.copy(build_zip.ROOT / name, tmp_path / name)
    monkeypatch.setattr(build_zip, "ROOT", tmp_path)
    monkeypatch.setattr(build_zip, "SOURCE", tmp_path / "addon" / "arap_deform")
    return tmp_path


def spoil(path: Path, pattern: str, replacement: str) -> None:
    text = path.read_text(encoding="utf-8")
    spoilt, n = re.subn(pattern, replacement, text, count=1, flags=re.MULTILINE)
    assert n == 1
    path.write_text(spoilt, encoding="utf-8")


@pytest.mark.parametrize(
    ("file", "pattern", "replacement", "message"),
    [
        (
            "addon/arap_deform/blender_manifest.toml",
            r'^version = ".*"',
            'version = "9.9.9"',
            r"blender_manifest\.toml states version 9\.9\.9, CMakeLists\.txt .*: make them equal",
        ),
        ("CMakeLists.txt", r"project\(arap VERSION", "project(arap", "has no line 'project\\(arap VERSION"),
    ],
)
def test_refuses_versions_that_differ(wheels, copied_source, file, pattern, replacement, message):
    folder = wheels("cp311")
    spoil(copied_source / file, pattern, replacement)
    with pytest.raises(ValueError, match=message):
        build_zip.build(folder, copied_source / "out")


def test_every_platform_has_a_zip(wheels, tmp_path):
    wheels("cp311", "cp313")
    folder = wheels("cp311", "cp313", platform="win_amd64")
    windows, linux = build_zip.build(folder, tmp_path)
    assert [path.name for path in (windows, linux)] == [
        f"arap_deform-{VERSION}-{platform}.zip" for platform in ("windows-x64", "linux-x64")
    ]
    assert 'platforms = ["windows-x64"]' in contents(windows)["blender_manifest.toml"].decode()
    assert {name for name in contents(linux) if name.startswith("wheels/")} == {
        f"wheels/arap_native-{VERSION}-{tag}-{tag}-{LINUX}.whl" for tag in ("cp311", "cp313")
    }
