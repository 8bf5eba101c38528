"""Forms made from the fields of specs."""
