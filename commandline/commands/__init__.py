"""The commands of `washboard` that do something, one file each."""
