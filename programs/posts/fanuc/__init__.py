"""Fanuc TP in its text form (LS)."""
