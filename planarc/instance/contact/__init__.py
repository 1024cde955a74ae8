"""The operator `impact` inside an exported model, in LLVM: what touches do next at an event.

area       memory that is no state
cases      forces of one case of some touches, and how far it breaks an inequality
lemke      cases of many touches, by Lemke's method
forces     forces and cases of touches, by complementarity
pressed    the same where joints rub, by forces that they cause themselves
touches    what touches read, and what forces at them do
blows      impulses of an impact
impacts    the operator

The rules, their tolerances and their sources are those of `solve.contact`.
"""
