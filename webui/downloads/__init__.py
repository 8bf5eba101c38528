"""Downloads: programs, reports, recordings of the playback."""
