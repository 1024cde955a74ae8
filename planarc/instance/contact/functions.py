"""All functions of contacts."""

from __future__ import annotations

from planarc.instance.contact.blows import blow_functions
from planarc.instance.contact.cases import case_functions
from planarc.instance.contact.forces import force_functions
from planarc.instance.contact.impacts import impact_functions
from planarc.instance.contact.lemke import lemke_functions
from planarc.instance.contact.pressed import pressed_functions
from planarc.instance.contact.touches import touch_functions


def contact_functions(asks: bool = False) -> tuple[str, ...]:
    """`asks`: a run in Python asks for them, which wants to know each strike."""
    return (*case_functions(), *lemke_functions(), *force_functions(), *pressed_functions(),
            *touch_functions(), *blow_functions(), *impact_functions(asks))  # fmt: skip
