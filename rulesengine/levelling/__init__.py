"""Levelling: spacings and speeds that lay an even film, or the required one in the least time."""
