"""One module for each change made to strokes after they are planned."""
