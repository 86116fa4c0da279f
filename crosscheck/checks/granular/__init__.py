"""Checks of soft grains, and of hard spheres run as soft ones."""
