"""Classes to one flat model. Each room needs those below it only (the contract in pyproject.toml).

pipeline    the whole stage: from the name of a class to its FlatModel
checks      the model as a whole: balance, ranges, what nobody heeds
sections    equations, figures and declarations of one class; parts that are alike, once
connect     connections over the whole hierarchy, as equations
instances   components: bindings, sizes, start values, inner and outer
functions   calls, arguments, bodies of functions
typing      expressions with types; units
values      evaluation while compiling
tree        classes and instances, filled on demand (`tree/demand`); lookup, modifiers
library     files and folders that classes come from; `terms` typed expressions by themselves
"""
