"""Studies: boards by recipes by parameter sets by values, in many processes: design, jobs, tables, picture."""

DISTRIBUTION = "washboard"
