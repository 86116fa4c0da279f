"""`crosscheck simulate`: runs one scene on one or more engines, and writes what they found."""
