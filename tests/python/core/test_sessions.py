# SPDX-License-Identifier: GPL-3.0-or-later
"""The registry of live sessions."""

from types import SimpleNamespace

from arap_deform.core import sessions


def test_registry_forgets_what_is_missing():
    sessions.clear()
    for name in ("Creature", "Gone"):
        sessions.put(name, sessions.Bound(session=object(), inputs=SimpleNamespace(counts=(8, 0, 0, 0))))
        sessions.set_readout(name, "readout")
    sessions.set_readout("Gone too", "readout")
    sessions.forget_missing(lambda name: name == "Creature")
    assert [sessions.get(name) is None for name in ("Creature", "Gone")] == [False, True]
    assert [sessions.readout(name) for name in ("Creature", "Gone", "Gone too")] == ["readout", None, None]


def test_idle_sessions_go_when_there_is_too_much_of_them():
    sessions.clear()

    def put(name, part):
        inputs = SimpleNamespace(counts=(round(part * sessions.IDLE_VERTICES), 0, 0, 0))
        sessions.put(name, sessions.Bound(session=object(), inputs=inputs))

    def there():
        return "".join(name for name in "ABCDEF" if sessions.get(name) is not None)

    put("A", 0.6)
    put("B", 0.4)
    put("A", 0.6)
    assert there() == "AB"
    put("C", 0.1)
    assert there() == "AC", "B was put before A"
    sessions.hold("C", "Live")
    act = SimpleNamespace(doing="it is posed")
    sessions.claim("D", act)
    put("D", 5.0)
    put("E", 9.0)
    assert there() == "CDE", "one that is held, one of an act, and the last one"
    sessions.drop_idle("C")
    assert there() == "CDE"
    sessions.let_go("C", "Live")
    sessions.release("D", act)
    put("F", 9.0)
    assert there() == "F"
    sessions.drop_idle("F")
    assert there() == ""


def test_registry_forgets_sessions_but_keeps_readouts_until_a_file_load():
    sessions.clear()
    bound = sessions.Bound(session=object(), inputs=SimpleNamespace(counts=(8, 0, 0, 0)))
    sessions.put("Creature", bound)
    sessions.set_readout("Creature", "readout")
    assert sessions.get("Creature") is bound
    sessions.drop("Creature")
    sessions.drop("Nobody")
    assert sessions.get("Creature") is None
    assert sessions.readout("Creature") == "readout"
    sessions.clear()
    assert sessions.readout("Creature") is None
