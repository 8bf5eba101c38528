"""Panels of the recipe: forms, text, unsaved changes."""
