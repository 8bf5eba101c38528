"""One module for each file format a board comes in."""
