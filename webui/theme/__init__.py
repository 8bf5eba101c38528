"""Colours of the page."""
