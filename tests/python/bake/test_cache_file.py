# SPDX-License-Identifier: GPL-3.0-or-later
"""Point caches, byte by byte."""

import struct

import numpy as np
import pytest
from arap_deform.bake.cache_file import CacheWriter, format_of

FRAMES = np.arange(2 * 3 * 3, dtype=np.float32).reshape(2, 3, 3) / 7.0


def write(path, frames=(10, 12), fps=25.0):
    writer = CacheWriter(path, 3, frames, fps)
    for frame in FRAMES:
        writer.append(frame)
    writer.finish()
    return path.read_bytes()


def test_mdd(tmp_path):
    data = write(tmp_path / "a.mdd")
    assert data[:8] == struct.pack(">2i", 2, 3)
    np.testing.assert_allclose(np.frombuffer(data[8:16], ">f4"), [0.0, 2 / 25.0])
    np.testing.assert_array_equal(np.frombuffer(data[16:], ">f4").reshape(FRAMES.shape), FRAMES)


def test_pc2(tmp_path):
    data = write(tmp_path / "A.PC2")
    assert struct.unpack("<12s2i2fi", data[:32]) == (b"POINTCACHE2\0", 1, 3, 10.0, 2.0, 2)
    np.testing.assert_array_equal(np.frombuffer(data[32:], "<f4").reshape(FRAMES.shape), FRAMES)


def test_one_frame(tmp_path):
    writer = CacheWriter(tmp_path / "a.pc2", 3, [7], 24.0)
    writer.append(FRAMES[0])
    writer.finish()
    assert struct.unpack("<12s2i2fi", (tmp_path / "a.pc2").read_bytes()[:32])[3:] == (7.0, 1.0, 1)


def test_a_file_is_there_once_it_is_whole(tmp_path):
    path = tmp_path / "a.mdd"
    path.write_text("older")
    writer = CacheWriter(path, 3, [1, 2], 24.0)
    writer.append(FRAMES[0])
    assert path.read_text() == "older"
    with pytest.raises(RuntimeError, match=r"a\.mdd lacks 1 frames: add them first$"):
        writer.finish()
    writer.discard()
    assert path.read_text() == "older"
    assert list(tmp_path.iterdir()) == [path]
    write(path)
    assert list(tmp_path.iterdir()) == [path]


def test_discard_after_finish_does_nothing(tmp_path):
    path = tmp_path / "a.mdd"
    writer = CacheWriter(path, 3, [1], 24.0)
    writer.append(FRAMES[0])
    writer.finish()
    writer.discard()
    assert path.is_file()


def test_frames_that_do_not_fit_are_refused(tmp_path):
    writer = CacheWriter(tmp_path / "a.mdd", 3, [1], 24.0)
    message = r"^A frame of shape \(4, 3\) does not fit into .*: 1 frames of shape \(3, 3\) are left$"
    with pytest.raises(ValueError, match=message):
        writer.append(np.zeros((4, 3)))
    writer.append(FRAMES[0])
    with pytest.raises(ValueError, match=r": 0 frames of shape \(3, 3\) are left$"):
        writer.append(FRAMES[0])
    writer.discard()


def test_other_ends_are_refused(tmp_path):
    message = r"^a\.abc is neither \.mdd nor \.pc2: give the cache one of these ends$"
    with pytest.raises(ValueError, match=message):
        format_of(tmp_path / "a.abc")


def test_places_that_cannot_be_written_are_refused(tmp_path):
    (tmp_path / "b.mdd").mkdir()
    with pytest.raises(ValueError, match=r"cannot be written \(No such file or directory\): choose another folder or"):
        CacheWriter(tmp_path / "nowhere" / "a.mdd", 3, [1], 24.0)
    with pytest.raises(ValueError, match=r"cannot be written \(Is a directory\): choose another folder or another"):
        CacheWriter(tmp_path / "b.mdd", 3, [1], 24.0)


@pytest.mark.skipif("not __import__('pathlib').Path('/dev/full').exists()", reason="there is no /dev/full")
def test_a_full_disk_is_said(tmp_path):
    (tmp_path / "a.mdd.part").symlink_to("/dev/full")
    writer = CacheWriter(tmp_path / "a.mdd", 100_000, [1], 24.0)
    message = r"a\.mdd could not be written \(No space left on device\): make room, or choose another place$"
    with pytest.raises(RuntimeError, match=message):
        writer.append(np.zeros((100_000, 3)))
    writer.discard()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif("not __import__('pathlib').Path('/dev/full').exists()", reason="there is no /dev/full")
def test_a_disk_that_is_full_from_the_beginning_leaves_nothing(tmp_path):
    (tmp_path / "a.mdd.part").symlink_to("/dev/full")
    with pytest.raises(
        ValueError, match=r"a\.mdd cannot be written \(No space left on device\): choose another folder"
    ):
        CacheWriter(tmp_path / "a.mdd", 3, range(100_000), 24.0)  # the header alone is longer than what is buffered
    assert list(tmp_path.iterdir()) == []
