"""``python -m washboard``."""

from commandline.start import main

main()
