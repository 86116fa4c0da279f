"""Compares results: matches frames and particles, tells rounding and chaos from another dynamics, and statistics."""
