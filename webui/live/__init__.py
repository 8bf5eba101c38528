"""The live view of an operation, served by the process that operates."""
