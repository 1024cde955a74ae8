"""One self-contained HTML page of a run: the moving mechanism beside curves."""
