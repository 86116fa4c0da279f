"""Forces: one module each, every one answering the questions of `generic`."""
