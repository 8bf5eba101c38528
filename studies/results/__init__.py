"""What a study found: summary, tables that are written and read, picture, page, terminal text."""
