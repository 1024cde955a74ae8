"""Errors of syntax that bring others with them, told apart by their type."""

from __future__ import annotations

from planarc.core.diagnostic import Diagnostic


class WrongEnd(Diagnostic):
    """`end B` of a class `A`."""


class StrayEnd(Diagnostic):
    """An `end if` for which no `if` is open."""


class WrongSection(Diagnostic):
    """An equation among declarations, or the like: one missing word makes many of them."""
