"""Recipe and board in, plan and timed program out."""

DISTRIBUTION = "washboard"
