"""The problem of a diagnosis: the question, the candidate effects, and how much each row of data counts.

``question`` says what may move in the model, ``candidates`` lists the effects that may be named, ``problem`` joins them
with the recordings' rows in folds. Start with ``problem.DiagnosisProblem``.
"""
