# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that have their name when they are whole."""

from pathlib import Path

import pytest
from arap_deform.bake.whole_file import WholeFile, check_space


def test_each_of_two_writers_of_one_file_names_its_own(tmp_path):
    path = tmp_path / "a.blend"
    first, second = WholeFile(path), WholeFile(path)
    assert first.part.parent == second.part.parent == tmp_path  # where a file takes a name in one act
    first.write(b"first")
    second.write(b"sec")
    first.finish()
    assert path.read_bytes() == b"first"
    second.write(b"ond")
    second.finish()
    assert path.read_bytes() == b"second"
    assert list(tmp_path.iterdir()) == [path]


def test_each_of_two_writers_discards_its_own(tmp_path):
    path = tmp_path / "a.blend"
    first, second = WholeFile(path), WholeFile(path)
    first.discard()
    second.write(b"second")
    second.finish()
    second.discard()  # does nothing any more
    assert path.read_bytes() == b"second"
    assert list(tmp_path.iterdir()) == [path]


def test_a_name_as_long_as_systems_take(tmp_path):
    path = tmp_path / ("a" * 249 + ".blend")
    whole = WholeFile(path)
    whole.finish()
    assert path.is_file()


def test_a_folder_that_cannot_be_written_is_refused(tmp_path, monkeypatch):
    def refuse(_path, _mode):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(ValueError, match=r"a\.blend cannot be written \(Permission denied\): choose another folder or"):
        WholeFile(tmp_path / "a.blend")


@pytest.mark.usefixtures("small_disk")
def test_a_disk_without_room_is_refused(tmp_path):
    check_space(tmp_path, 1_000_000, "It")
    message = r"^It takes 2 MB, 1 MB more than \S+ has free: free disk space there, or choose another folder$"
    with pytest.raises(ValueError, match=message):
        check_space(tmp_path, 2_000_000, "It")
