"""What a person reads of a result: pictures, pages, tables, terminal text, and the files of them."""

DISTRIBUTION = "washboard"
