"""Languages of machines whose blocks name axes: one module each, on a common base."""
