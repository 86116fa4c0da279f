"""Names that the user of the pytest plugin meets."""

#: The marker, and the fixture that a marked test may take.
MARKER, FIXTURE = "crosscheck", "crosscheck_verdict"
#: Properties of the tests, in JUnit XML and in reports; the others are quantities.
OUTCOME, CASE, ENGINE = "crosscheck outcome", "crosscheck case", "crosscheck engine"
#: What the names of tests that are no functions start with.
ROOM = "crosscheck"
