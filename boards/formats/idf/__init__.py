"""IDF 2 and 3: board, placement and library of heights."""
