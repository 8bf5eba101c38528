"""One card for each subject, made of results: what terminal, HTML and page say of it."""
