"""Eagle boards, versions 6 to 9: outline, placed packages, pads and heights by name."""
