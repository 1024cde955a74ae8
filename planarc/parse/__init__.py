"""Text to syntax tree: `grammar` reads tokens, `build` makes nodes, `repair` explains mistakes."""
