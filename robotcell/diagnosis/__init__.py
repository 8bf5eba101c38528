"""Findings about a cell and a motion, and what would help."""
