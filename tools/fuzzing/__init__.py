"""Mutation of every input: what targets there are, what their cases are made of, and what counts as a defect."""
