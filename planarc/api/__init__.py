"""What a user holds in Python: `Model`, `Result`, and the analyses of a model, one a file."""
