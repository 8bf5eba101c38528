"""The exposed surface: facets, cells, open sky, and the scene that rays meet."""
