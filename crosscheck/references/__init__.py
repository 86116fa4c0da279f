"""What is known: closed forms and published values, each with its source."""
