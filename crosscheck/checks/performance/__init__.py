"""Checks of speed, and error against run time."""
