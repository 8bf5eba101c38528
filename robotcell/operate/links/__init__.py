"""Links to controllers: one module a kind, each with one function that opens it."""
