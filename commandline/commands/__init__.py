"""The commands of `washboard`, one file each."""
