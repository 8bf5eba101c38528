"""Mutation fuzz of every reader, as the commands call it."""
