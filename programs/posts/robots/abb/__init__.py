"""ABB RAPID, with and without the paint option."""
