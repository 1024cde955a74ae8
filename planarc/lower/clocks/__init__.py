"""Clocked parts of a model: who ticks together, how often, and what holds at a tick.

parts       equations and variables in parts that tick together; the rest is continuous
refusals    what is said where parts run into each other without an operator between
rates       how often each part ticks, from the clocks that are given and the operators between
ticks       parts as discrete equations that hold where their clock ticks
"""
