"""Cells: their YAML, shapes, robots of the library and where the board is held."""
