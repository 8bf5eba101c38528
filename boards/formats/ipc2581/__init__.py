"""IPC-2581 boards, revisions B and C: profile, placed packages, pads, heights and panels."""
