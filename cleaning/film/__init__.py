"""The film that runs along the board, and the pressure it puts on the edges of undersides."""
