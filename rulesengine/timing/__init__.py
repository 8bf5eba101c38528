"""Plan to timed program: corners, coupled limits, speed profile, sampling."""
