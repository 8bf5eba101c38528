"""Mitsubishi MELFA-BASIC V and VI."""
