"""Verdicts on the runs of any scene: all that its parts imply, whatever it is."""
