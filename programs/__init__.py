"""What the nozzle is told: plans, timed programs, their files."""
