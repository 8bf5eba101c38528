"""One module for each path class: its spec in, its strokes out."""
