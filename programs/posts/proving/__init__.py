"""Compares what a program's text does with what was planned, and predicts its time."""
