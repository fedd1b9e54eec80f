# SPDX-License-Identifier: GPL-3.0-or-later
"""Point caches, byte by byte."""

import os
import struct
from pathlib import Path

import numpy as np
import pytest
from arap_deform.bake.cache_file import CacheWriter, format_of

FRAMES = np.arange(2 * 3 * 3, dtype=np.float32).reshape(2, 3, 3) / 7.0


def write(path, frames=(10, 12), fps=25.0):
    writer = CacheWriter(path, 3, frames, fps)
    for positions in FRAMES[: len(frames)]:
        writer.append(positions)
    writer.finish()
    return path.read_bytes()


def test_mdd(tmp_path):
    data = write(tmp_path / "a.mdd")
    assert data[:8] == struct.pack(">2i", 2, 3)
    np.testing.assert_allclose(np.frombuffer(data[8:16], ">f4"), [0.0, 2 / 25.0])
    np.testing.assert_array_equal(np.frombuffer(data[16:], ">f4").reshape(FRAMES.shape), FRAMES)


@pytest.mark.parametrize(("frames", "numbers"), [((10, 12), (10.0, 2.0, 2)), ((7,), (7.0, 1.0, 1))])
def test_pc2(tmp_path, frames, numbers):
    data = write(tmp_path / "A.PC2", frames)
    assert struct.unpack("<12s2i2fi", data[:32]) == (b"POINTCACHE2\0", 1, 3, *numbers)
    shape = (len(frames), 3, 3)
    np.testing.assert_array_equal(np.frombuffer(data[32:], "<f4").reshape(shape), FRAMES[: len(frames)])


def test_a_file_is_there_once_it_is_whole(tmp_path):
    path = tmp_path / "a.mdd"
    path.write_text("older")
    writer = CacheWriter(path, 3, [1, 2], 24.0)
    writer.append(FRAMES[0])
    assert path.read_text() == "older"
    writer.discard()
    assert path.read_text() == "older"
    assert list(tmp_path.iterdir()) == [path]
    write(path)
    assert list(tmp_path.iterdir()) == [path]
    writer.discard()  # does nothing any more
    assert path.is_file()


def test_other_suffixes_are_refused(tmp_path):
    message = r"^a\.abc: the file name must end in \.mdd or \.pc2$"
    with pytest.raises(ValueError, match=message):
        format_of(tmp_path / "a.abc")


def test_places_that_cannot_be_written_are_refused(tmp_path):
    (tmp_path / "b.mdd").mkdir()
    with pytest.raises(ValueError, match=r"cannot be written \(No such file or directory\): choose another folder or"):
        CacheWriter(tmp_path / "nowhere" / "a.mdd", 3, [1], 24.0)
    with pytest.raises(ValueError, match=r"cannot be written \(Is a directory\): choose another folder or another"):
        CacheWriter(tmp_path / "b.mdd", 3, [1], 24.0)


@pytest.fixture
def full_disk(monkeypatch):
    """Every file is on it."""
    if not Path("/dev/full").exists():
        pytest.skip("there is no /dev/full")

    def open_on_full_disk(path, mode):
        path.touch(exist_ok="x" not in mode)
        return os.fdopen(os.open("/dev/full", os.O_WRONLY), "wb")

    monkeypatch.setattr(Path, "open", open_on_full_disk)


@pytest.mark.usefixtures("full_disk")
def test_a_full_disk_is_said(tmp_path):
    writer = CacheWriter(tmp_path / "a.mdd", 100_000, [1], 24.0)
    message = r"a\.mdd could not be written \(No space left on device\): free disk space, or choose another folder$"
    with pytest.raises(RuntimeError, match=message):
        writer.append(np.zeros((100_000, 3)))
    writer.discard()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("full_disk")
def test_a_disk_that_is_full_from_the_beginning_leaves_nothing(tmp_path):
    message = r"a\.mdd could not be written \(No space left on device\): free disk space, or choose another folder$"
    with pytest.raises(RuntimeError, match=message):
        CacheWriter(tmp_path / "a.mdd", 3, range(100_000), 24.0)  # the header alone is longer than what is buffered
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("small_disk")
def test_a_disk_without_room_for_all_frames_is_said_before_the_first(tmp_path):
    message = r"^\S+a\.pc2 takes 1 MB, 8 kB more than \S+ has free: free disk space there, or choose another folder$"
    CacheWriter(tmp_path / "a.pc2", 1000, range(83), 24.0).discard()
    with pytest.raises(ValueError, match=message):
        CacheWriter(tmp_path / "a.pc2", 1000, range(84), 24.0)
    assert list(tmp_path.iterdir()) == []


def test_two_writers_of_one_file(tmp_path):
    """The file is whole whenever it is there, and of the one that has ended last."""
    path = tmp_path / "a.pc2"
    writers = [CacheWriter(path, 3, [1, 2], 24.0) for _ in range(2)]
    n_bytes = 32 + 2 * 3 * 12
    writers[0].append(FRAMES[0])
    writers[1].append(FRAMES[1])
    for writer, frame in zip(writers, FRAMES, strict=True):
        writer.append(frame)
        writer.finish()
        assert path.stat().st_size == n_bytes
    np.testing.assert_array_equal(np.frombuffer(path.read_bytes()[32:], "<f4").reshape(FRAMES.shape), FRAMES[[1, 1]])
    assert list(tmp_path.iterdir()) == [path]
