"""Changing a recipe until all that it can clean is predicted clean."""
