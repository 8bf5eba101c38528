"""Whether a robot can do it: cells, kinematics, collisions, joint motion. Metres and radians stay in here."""

DISTRIBUTION = "washboard"
