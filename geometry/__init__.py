"""Arrays, frames, polygons, meshes, coverage. Knows nothing about spraying."""
