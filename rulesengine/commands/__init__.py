"""One module for each group of commands; everything heavy is imported inside them."""
