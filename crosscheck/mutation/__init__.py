"""The mutation score: which share of small random bugs in the sources the checks see. See docs/mutation.md."""
