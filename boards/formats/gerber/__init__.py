"""Gerber layers, with X2 attributes: the profile of a board, and the copper of its components."""
