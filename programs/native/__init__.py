"""The native program file: writer and reader."""
