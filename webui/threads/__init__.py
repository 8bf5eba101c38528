"""Threads of the page: worker, throttle, playback clock."""
