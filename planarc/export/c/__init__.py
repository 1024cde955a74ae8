"""A model as C99, translated from the LLVM text that all exports are made of.

source      one call: a compiled model becomes files
entries     what a C program calls of a model
listing     the texts of LLVM as data
body        a function of LLVM as one of C: its jumps
statements  its instructions between jumps
rows        its lines, when all are written
formulas    an instruction as an expression of C
texts       what the files hold beside
"""
