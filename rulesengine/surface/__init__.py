"""The geometry-based planner: stripes over the faces of a part, tilted only where a collision makes it necessary."""
