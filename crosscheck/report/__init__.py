"""What people and machines read after a run: one HTML file, JUnit XML."""
