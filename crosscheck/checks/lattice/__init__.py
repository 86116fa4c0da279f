"""Checks of lattice gases."""
