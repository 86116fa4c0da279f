"""Forces: one module each, which implements the functions of `generic` for its record."""
