"""The data between the stages: types only, no passes.

syntax -> flat -> dae -> sorted -> program -> result      one module a stage's data
expr, calculus, actions        the expression tree from `dae` to `program`
text/                          printers of these data; their checkers are tests/ir/check/
"""
