"""KiCad boards: outline, footprints, pads and heights from models."""
