"""The handbook of a library, gathered from its syntax trees: no class is flattened."""
