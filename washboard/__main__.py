"""``python -m washboard``."""

from washboard.start import main

main()
