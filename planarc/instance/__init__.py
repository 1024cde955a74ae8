"""A model that runs in machine code alone, in LLVM by `codegen.native`'s notation: start, steps,
events, other states. All of it runs inside an exported model, the iteration of events and steps
with crowds in any run.

plan        the memory of one instance, and what its code must know of the model
clauses     what clauses do, in order, and what they set
actions     the same as code
touches     what its rigid contacts read and set
block       the memory of an instance: made, saved, read, set
reaching    points that a host asks for far from the accepted one
start       start values that fit together, from the assembly found at export
states      other states where the present ones go bad
steps       an integrator of its own
advance     its way to a time
relations   zero functions, stored truths, and what crosses
instants    time events
settling    truths and discrete values iterated at one instant
events      what happens at an instant, at the start and at the end
contact     impacts, stops, friction of rigid bodies (`impact`)
crowd       steps of one length, for very many bodies (`crowd`)
ends        steps that end at events
within      crossings within a step that neither its stages nor its end show
uneventful  the same for models without any
stiff       implicit steps
slopes      exact derivatives by states and inputs
reaction    events of a run in Python: the code that it asks
reactor     the same: memory and call
"""
