"""Cells: their YAML, shapes, robots of the library and the pose of the board."""
