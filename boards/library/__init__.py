"""Sample boards, and the script that writes them: ``python -m boards.library.write_samples``."""
