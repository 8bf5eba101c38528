"""What was measured of the cleanliness of each component, compared with what an analysis predicts."""
