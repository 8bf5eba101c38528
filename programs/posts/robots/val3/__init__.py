"""Staubli VAL3."""
