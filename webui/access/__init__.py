"""Access control of the page: which requests are answered, what uploads may hold."""
