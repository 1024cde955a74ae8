"""Names near to a misspelt one: one measure, one cut-off and one wording for all messages."""

from __future__ import annotations

from collections.abc import Iterable

from planarc.core.prose import either

MOST = 3  # names in a hint
#: Words of the field, in small letters, and names that libraries give to the same thing.
SYNONYMS = {
    "acceleration": ("a", "z"),
    "alpha": ("z", "a"),
    "arccos": ("acos",),
    "arcsin": ("asin",),
    "arctan": ("atan",),
    "arctan2": ("atan2",),
    "bar": ("BodyShape", "FixedTranslation"),
    "beam": ("BodyShape", "FixedTranslation"),
    "bearing": ("Revolute", "Fixed", "BearingFriction"),
    "angle": ("phi",),
    "damper": ("Damper",),
    "damping": ("d",),
    "distance": ("s",),
    "fabs": ("abs",),
    "flange": ("axis", "flange_a", "flange_b"),
    "force": ("f",),
    "frequency": ("f",),
    "gravity": ("g",),
    "ground": ("Fixed",),
    "hinge": ("Revolute",),
    "i": ("J",),
    "inertia": ("I", "J", "Inertia"),
    "j": ("I",),
    "input": ("u", "u1"),
    "k": ("c",),
    "kd": ("Td",),
    "ki": ("Ti",),
    "kp": ("k",),
    "l0": ("s_unstretched", "s_rel0"),
    "length": ("L", "s_unstretched", "s", "r"),
    "link": ("BodyShape", "FixedTranslation"),
    "ln": ("log",),
    "mass": ("m", "Mass", "Body", "PointMass"),
    "moment": ("tau", "t"),
    "omega": ("w",),
    "output": ("y",),
    "pin": ("Revolute",),
    "position": ("s", "r"),
    "radius": ("R", "r"),
    "rod": ("BodyShape", "FixedTranslation"),
    "shaft": ("axis", "flange_b"),
    "slider": ("Prismatic",),
    "speed": ("w", "v"),
    "squareroot": ("sqrt",),
    "stiffness": ("c",),
    "tau": ("t",),
    "theta": ("phi",),
    "torque": ("tau", "t"),
    "velocity": ("v", "w"),
}
CUTOFF = 0.6  # share of letters that two names have in common, in their order


def nearest(name: str, known: Iterable[str], most: int = MOST, cutoff: float = CUTOFF) -> list[str]:
    """The names most like `name`, best first; else those that differ in capitals only."""
    from difflib import get_close_matches

    names = list(dict.fromkeys(known))
    lower = name.lower()
    near = get_close_matches(name, names, most, cutoff)
    return near or [n for n in names if n.lower() == lower][:most]


def synonyms(name: str, known: Iterable[str]) -> list[str]:
    """Known names that say the same in the field's words: `hinge.w` for `hinge.omega`."""
    names = set(known)
    head, dot, last = name.rpartition(".")
    return [m for w in SYNONYMS.get(last.lower(), ()) if (m := head + dot + w) in names]


def did_you_mean(name: str, known: Iterable[str], most: int = MOST) -> str | None:
    """The hint that names what a user may have meant; None where nothing is near."""
    names = list(known)
    ending = [n for n in names if n.endswith(f"_{name}")]  # `frame_b` for `b`
    return meant((synonyms(name, names) or ending)[:most] or nearest(name, names, most))


def meant(names: Iterable[str]) -> str | None:
    found = either(names)
    return f"did you mean {found}?" if found else None
