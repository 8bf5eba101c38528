"""Tuning from the page: in the background, as proposals and quick fixes."""
