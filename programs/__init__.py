"""Plans, timed programs, and the robot programs made from them."""

DISTRIBUTION = "washboard"
