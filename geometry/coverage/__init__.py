"""How a region is covered: stripes across it, and the order in which strokes are done."""
