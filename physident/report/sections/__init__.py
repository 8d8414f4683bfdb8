"""The sections of a report, in the order of the page: answer, joint_errors, causes, torques, evidence, unseen, advice,
provenance.

Each function returns markup from a diagnosis. Start with ``answer``.
"""
