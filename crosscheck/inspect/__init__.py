"""Inspects one trajectory alone: what its frames, motion, velocities and structure say, each with a verdict."""
