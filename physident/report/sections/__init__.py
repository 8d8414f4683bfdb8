"""The sections of a report, one a file, in the order of the page: answer, levels, causes, evidence, torques, limits,
advice, provenance.

Each returns markup made from a diagnosis. Start with ``answer``.
"""
