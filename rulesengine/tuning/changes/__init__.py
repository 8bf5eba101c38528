"""Candidate changes of a recipe and what each is expected to do."""
