"""A program split into stages of washing, rinsing and drying."""
