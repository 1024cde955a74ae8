"""Statements over a workspace, made once (`pipeline`) and printed twice (`numpy/`, `native/`).

`sections` lists the statements, `tables` says what each slot means, `slopes` derives all of it.
"""
