"""One module for each language a program is written in."""
