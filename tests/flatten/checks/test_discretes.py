"""A discrete variable that is given what changes between events is refused, and no other."""

from __future__ import annotations

import pytest

import planarc

HEAD = """model M
  function f
    input Real u;
    output Integer k;
  algorithm
    k := integer(3*u);
  end f;
  function pair
    input Real u;
    output Integer k;
    output Real z;
  algorithm
    k := integer(3*u);
    z := u;
  end pair;
  record R Integer k; Real z; end R;
  function made
    input Real u;
    output R r;
  algorithm
    r := R(integer(3*u), u);
  end made;
  type E = enumeration(a, b);
"""

REFUSED = {
    "a function": "Integer k; equation k = f(time);",
    "the other side": "Integer k; equation f(time) = k;",
    "a binding": "Integer k = f(time);",
    "an algorithm": "Integer k; algorithm k := f(time);",
    "a loop": "Integer k; algorithm for i in 1:f(time) loop k := i; end for;",
    "a field": "R r; equation r = R(f(time), time);",
    "an entry": "Integer k[2]; equation k = {1, f(time)};",
    "all entries": "Integer k[2]; equation k = {f(time*i) for i in 1:2};",
    "a Real of an algorithm": "Real z = sin(time); discrete Real x; algorithm x := z;",
    "a discrete Real": "discrete Real x; equation x = sin(time);",
    "a branch": "discrete Real x; equation if time > 1 then x = time; else x = 1; end if;",
}
WARNED = {
    "a relation": "Boolean b; equation b = noEvent(time > 0.5);",
    "a binding": "Boolean b = noEvent(time > 0.5);",
    "a rounded number": "Integer k; equation k = noEvent(integer(3*time));",
    "a condition": "Integer k; equation k = if noEvent(time > 0.5) then 1 else 2;",
    "a literal": "E e; equation e = noEvent(if time > 0.5 then E.b else E.a);",
    "a branch": "Integer k; equation if noEvent(time > 1) then k = 1; else k = 2; end if;",
    "an algorithm": "Integer k; algorithm if noEvent(time > 1) then k := 1; else k := 2; end if;",
    "one of several results": "Integer k; Real z; equation (k, z) = pair(time);",
    "a record": "R r; equation r = made(time);",
}
ACCEPTED = {
    "a relation of a function": "Boolean b; equation b = f(time) > 1;",
    "a rounded number": "Integer k; equation k = integer(3*time);",
    "a function of discrete values": "Integer n = integer(time); Integer k = f(n);",
    "what a when sets": "Integer k; equation when sample(0, 0.1) then k = f(time); end when;",
    "a function of what a when sets": "Real x; Integer k; "
    "equation when sample(0, 0.1) then x = time; end when; k = f(x);",
    "a Real that equals an Integer": "Integer k = integer(time); Real x(start=0, fixed=true); "
    "equation der(x) = k;",
    "records": "R a[2](k={1, 2}, z={time, 2}), b[2]; equation a = b;",
    "a field": "R r; equation r = R(integer(time), time);",
    "an index": "Boolean b[3] = {time > 0.1*i for i in 1:3}; Integer n; "
    "equation n = sum(if b[i] then i else 0 for i in 1:3);",
    "the past, without events": "Integer n; Boolean b; equation "
    "when time > 0.5 then n = pre(n) + 1; end when; b = noEvent(pre(n) > 0);",
    "a size": "Real x[2] = {time, 2}; Integer n; equation n = noEvent(size(x, 1));",
    "a discrete Real of relations": "discrete Real x; equation x = if time > 1 then 1 else 2;",
}


def told(body: str) -> list[str]:
    """The warnings F284 of a model."""
    return [
        w.message for w in planarc.load(f"{HEAD}  {body}\nend M;\n").warnings if w.code == "F284"
    ]


@pytest.mark.parametrize("body", REFUSED.values(), ids=REFUSED)
def test_what_changes_between_events_is_refused(body: str) -> None:
    with pytest.raises(planarc.PlanarcError) as caught:
        told(body)
    assert {d.code for d in caught.value.diagnostics} == {"F284"}


@pytest.mark.parametrize("body", WARNED.values(), ids=WARNED)
def test_what_hides_its_events_is_told(body: str) -> None:
    messages = told(body)
    assert messages
    assert all("is followed at events only" in m for m in messages)


@pytest.mark.parametrize("body", ACCEPTED.values(), ids=ACCEPTED)
def test_what_makes_events_is_right(body: str) -> None:
    assert told(body) == []


@pytest.mark.parametrize("given", ["k = f(time);", "(k, ) = pair(time);"])
def test_the_cure_works(given: str) -> None:
    body = "Integer k; Real z, y(start=0, fixed=true); equation der(y) = k; (, z) = pair(time); "
    body += f"when sample(0, 0.01) then {given} end when;"
    result = planarc.load(f"{HEAD}  {body}\nend M;\n").simulate(1.0)
    assert result["y"][-1] == pytest.approx(1, abs=0.02)  # 0/3 + 1/3 + 2/3
