"""What the page gives to download: programs, reports, playback recordings."""
