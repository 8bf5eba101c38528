"""Commands about what is given, with their subcommands: `washboard board show`; one file each."""
