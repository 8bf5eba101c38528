"""One card for each subject, made of results: what terminal, HTML and page show of it."""
