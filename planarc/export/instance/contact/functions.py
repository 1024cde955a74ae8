"""All functions of contacts."""

from __future__ import annotations

from planarc.export.instance.contact.blows import blow_functions
from planarc.export.instance.contact.cases import case_functions
from planarc.export.instance.contact.forces import force_functions
from planarc.export.instance.contact.impacts import impact_functions
from planarc.export.instance.contact.lemke import lemke_functions
from planarc.export.instance.contact.pressed import pressed_functions
from planarc.export.instance.contact.touches import touch_functions


def contact_functions() -> tuple[str, ...]:
    return (*case_functions(), *lemke_functions(), *force_functions(), *pressed_functions(),
            *touch_functions(), *blow_functions(), *impact_functions())  # fmt: skip
