"""Strokes, and what path planners need to make them: classes, outlines, safe heights."""
