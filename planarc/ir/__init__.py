"""The data between the stages: types only, no passes.

syntax -> flat -> dae -> sorted -> program -> result      one module a stage's data
expr, calculus, actions        the expression tree from `dae` to `program`
check/, text/                  checkers and printers of these data
"""
