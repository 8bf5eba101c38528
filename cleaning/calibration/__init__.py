"""Fits of ring patterns and of removal kinetics to measurements, with confidence intervals."""
