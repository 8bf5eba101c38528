"""Faults at the system calls of commands: the calls, and the runs with a fault at one of them."""
