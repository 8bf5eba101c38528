"""Panels of the board, its components and the paths."""
