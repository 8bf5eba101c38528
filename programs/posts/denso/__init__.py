"""Denso PacScript."""
