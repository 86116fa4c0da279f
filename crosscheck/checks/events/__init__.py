"""Checks of event-driven dynamics of hard disks and spheres."""
