"""Arrays, frames, polygons, meshes, coverage. Knows nothing about spraying."""

DISTRIBUTION = "washboard"
