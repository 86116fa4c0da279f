"""Trajectories: what they hold, and their files."""
