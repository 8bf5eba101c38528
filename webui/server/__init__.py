"""The server: sessions, layout, files watched."""
