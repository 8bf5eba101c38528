"""What the jet achieves: exposure, flow under components, residue, rinse, drying, verdicts."""
