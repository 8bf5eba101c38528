"""Epson SPEL+."""
