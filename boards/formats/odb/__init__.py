"""ODB++ boards, version 7 and 8: profile, placed packages, toeprints, heights and panels."""
