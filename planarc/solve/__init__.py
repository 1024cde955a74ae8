"""A program becomes rows. Each room needs those below it only (the contract in pyproject.toml).

simulate    one call: request, run, result
run         the loop from the start to the end; it alone moves the run
begun       its start: values that fit together, the first row
bench       its parts, and what it does at every stop
start       consistent values: a loop is put together, what is held is held
events      what switches at an instant, iterated until it rests
stepping    steps with contacts, for very many of them, instead of events
contact     what touches of rigid bodies do next: impacts, sticking, sliding, letting go
states      which candidates are states, watched and exchanged on the way
messages    why a run cannot go on, in words
solvers     integrators, one a file, made by `choice`
kernels     generated code made callable: `numpy` and `native`
"""
