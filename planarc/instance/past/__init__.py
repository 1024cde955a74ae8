"""The past of delayed signals inside an exported model, in LLVM: only models with `delay` have it.

layout     memory
pieces     polynomials, one a step; where room ends, neighbours become one
record     a step becomes past
kinks      instants at which signals jump, until each delay has passed
start      the past before the start
functions  all of them

What they do, and why, stands in `solve.events.delays`, which does it for a run.
"""
