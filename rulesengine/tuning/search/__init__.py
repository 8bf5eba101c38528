"""The steps of the search: improve, tighten, accept."""
