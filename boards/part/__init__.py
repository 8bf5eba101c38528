"""Parts: workpieces of any shape, with their faces and fixtures."""
