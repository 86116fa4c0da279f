"""Two results of the same cases: what is worse, what is better, and what cannot be told; baselines. docs/regression.md.

results     what two runs are compared by, from a record or from a baseline
change      whether a number differs by more than two right runs do
work        numbers of operations, and computing times beside another engine of the same run
difference  all cases of two results, by categories, and what exit status follows
baseline    a small text file of results that are known, and its edits
shown       a difference as lines for a terminal, as Markdown and as JSON
"""
