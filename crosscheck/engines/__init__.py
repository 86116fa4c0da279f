"""Engines: one module each, every one in its own worker process."""
