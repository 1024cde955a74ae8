"""The objects of a user in Python: `Model`, `Result`, and the analyses of a model, one a file."""
