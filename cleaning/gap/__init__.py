"""Flow in the gap under a component: grid, Hele-Shaw solution, joints, filling."""
