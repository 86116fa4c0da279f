"""Readers, a module a format: each opens a file as a `Source`, or as a `Series`."""
