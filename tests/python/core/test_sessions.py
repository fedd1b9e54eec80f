# SPDX-License-Identifier: GPL-3.0-or-later
"""The registry of live sessions."""

import gc
import sys
import weakref
from types import SimpleNamespace

import arap_native
import numpy as np
import pytest
import sample_meshes
from arap_deform.core import sessions
from arap_deform.core.background import run
from arap_deform.core.session import Session
from arap_deform.core.session_data import SessionMesh, SessionSettings
from arap_deform.core.targets import HandleSpec


def test_registry_forgets_what_is_gone():
    sessions.clear()
    there, gone, unbound = 1, 2, 3
    for uid in (there, gone):
        sessions.put(uid, sessions.Bound(session=object(), inputs=SimpleNamespace(counts=(8, 0, 0, 0))))
        sessions.set_stats(uid, "stats")
    sessions.set_stats(unbound, "stats")
    sessions.forget({gone, unbound})
    assert [sessions.get(uid) is None for uid in (there, gone)] == [False, True]
    assert [sessions.stats(uid) for uid in (there, gone, unbound)] == ["stats", None, None]


def test_idle_sessions_go_when_there_is_too_much_of_them():
    sessions.clear()

    def put(name, part):
        inputs = SimpleNamespace(counts=(round(part * sessions.IDLE_VERTICES), 0, 0, 0))
        sessions.put(ord(name), sessions.Bound(session=object(), inputs=inputs))

    def there():
        return "".join(name for name in "ABCDEF" if sessions.get(ord(name)) is not None)

    put("A", 0.6)
    put("B", 0.4)
    put("A", 0.6)
    assert there() == "AB"
    put("C", 0.1)
    assert there() == "AC", "B was put before A"
    sessions.hold(ord("C"), "Follow")
    act = SimpleNamespace(doing="it is posed")
    sessions.lock(SimpleNamespace(session_uid=ord("D"), name="D"), act)
    put("D", 5.0)
    put("E", 9.0)
    assert there() == "CDE", "one that is held, one of an act, and the last one"
    sessions.drop_idle(ord("C"))
    assert there() == "CDE"
    sessions.release(ord("C"), "Follow")
    sessions.unlock(ord("D"), act)
    put("F", 9.0)
    assert there() == "F"
    sessions.drop_idle(ord("F"))
    assert there() == ""


def test_registry_forgets_sessions_but_keeps_readouts_until_a_file_load():
    sessions.clear()
    bound = sessions.Bound(session=object(), inputs=SimpleNamespace(counts=(8, 0, 0, 0)))
    sessions.put(1, bound)
    sessions.set_stats(1, "stats")
    assert sessions.get(1) is bound
    sessions.drop(1)
    sessions.drop(2)
    assert sessions.get(1) is None
    assert sessions.stats(1) == "stats"
    sessions.clear()
    assert sessions.stats(1) is None


@pytest.mark.skipif(sys.platform != "linux", reason="only the C library of Linux keeps freed memory")
def test_memory_of_forgotten_sessions_goes_back_to_the_system(monkeypatch):
    sessions.clear()
    refs, alive = [], []

    def malloc_trim(pad):
        alive.append((pad, [ref() for ref in refs]))

    def bind(uid):
        sheet = sample_meshes.sheet(120)
        mesh = SessionMesh(sheet.positions, sheet.corner_vertices, sheet.face_sizes)
        session = run(Session.bind(arap_native, mesh, np.eye(3), SessionSettings()))
        edge = np.arange(120, dtype=np.int32)
        run(session.set_handles([HandleSpec("Edge", edge, np.ones(120))]))
        session.update(np.eye(4)[None])
        refs.extend([weakref.ref(session), weakref.ref(session._model)])
        sessions.put(uid, sessions.Bound(session, SimpleNamespace(counts=(len(sheet.positions), 0, 0, 0))))

    for uid in (1, 2):
        bind(uid)
    assert all(ref() is not None for ref in refs)
    gc.disable()
    monkeypatch.setattr(sessions.ctypes, "CDLL", lambda _: SimpleNamespace(malloc_trim=malloc_trim))
    sessions.clear()
    gc.enable()
    assert alive == [(0, [None] * 4)], "all are gone when the library gives back what is free"
