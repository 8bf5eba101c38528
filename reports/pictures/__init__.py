"""Pictures of boards, paths, gaps, joints, cells and curves."""
