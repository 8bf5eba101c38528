"""Heat maps on the surface and in the gaps."""
