"""What is to be cleaned: boards, their components and how they are read from CAD."""

DISTRIBUTION = "washboard"
