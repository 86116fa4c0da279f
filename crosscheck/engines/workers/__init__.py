"""Engines in worker processes: the pool that the suite asks, and the worker that answers."""
