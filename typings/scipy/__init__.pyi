"""Names of SciPy that are used. It has no types: to infer them from its code takes a fifth of a type check."""
