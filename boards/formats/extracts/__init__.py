"""Boards as layout systems extract them for test and assembly: GenCAD, and the views of Allegro."""
