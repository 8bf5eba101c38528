"""Solids of any shape: whether a mesh is sound, its faces, its sections, and how near a rod comes to it."""
