"""The handbook of a library: classes in, one HTML page out."""
