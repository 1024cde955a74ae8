"""Analyses of a compiled model, one a file; `planarc.Model` is the door to them."""
