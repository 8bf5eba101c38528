"""Washing, rinsing and drying of one gap through all stages."""
