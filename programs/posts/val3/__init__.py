"""Stäubli VAL 3."""
