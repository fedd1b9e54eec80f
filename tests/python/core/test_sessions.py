# SPDX-License-Identifier: GPL-3.0-or-later
"""The registry of live sessions."""

from arap_deform.core import sessions


def test_registry_forgets_what_is_missing():
    sessions.clear()
    for name in ("Creature", "Gone"):
        sessions.put(name, sessions.Bound(session=object(), inputs=object()))
        sessions.set_readout(name, "readout")
    sessions.set_readout("Gone too", "readout")
    sessions.forget_missing(lambda name: name == "Creature")
    assert [sessions.get(name) is None for name in ("Creature", "Gone")] == [False, True]
    assert [sessions.readout(name) for name in ("Creature", "Gone", "Gone too")] == ["readout", None, None]


def test_registry_forgets_sessions_but_keeps_readouts_until_a_file_load():
    sessions.clear()
    bound = sessions.Bound(session=object(), inputs=object())
    sessions.put("Creature", bound)
    sessions.set_readout("Creature", "readout")
    assert sessions.get("Creature") is bound
    sessions.drop("Creature")
    sessions.drop("Nobody")
    assert sessions.get("Creature") is None
    assert sessions.readout("Creature") == "readout"
    sessions.clear()
    assert sessions.readout("Creature") is None
