"""Placement tables and bills of materials, joined to a board."""
