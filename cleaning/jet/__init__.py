"""What leaves the nozzle: flow, distribution by direction, footprint on a plane."""
