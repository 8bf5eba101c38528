"""The board file of Washboard and its older forms: triangles with components."""
