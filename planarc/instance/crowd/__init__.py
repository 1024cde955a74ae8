"""Steps of one length with crowds in LLVM, for an exported model or a run in Python: Moreau's
midpoint rule.

layout      the table of a model's ports and bodies, what is remembered, and memory that is no state
table       that table, and what stands in no slot
places      values and pushes of ports, states and their derivatives
meetings    which bodies are near each other, and where they would touch
response    how ports and states answer to forces, and the matrix of all contacts
impulses    the impulses of all contacts at once
steps       a step, and the states within it
stepping    steps of a run in Python: the code that it asks
stepper     the same: memory and call

The rules, their tolerances and their sources are those of `solve.stepping`, the operations are the
same in the same order: a heap magnifies the last digit.
"""
