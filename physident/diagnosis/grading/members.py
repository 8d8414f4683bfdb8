"""Which accepted effects a finding joins."""

from __future__ import annotations

from physident.diagnosis.result.findings import Finding
from physident.diagnosis.search.hypothesis import Hypothesis


def members(hypothesis: Hypothesis, finding: Finding) -> list[int]:
    """The accepted effects of a hypothesis (their indices) that a finding joins."""
    return [
        i
        for i, one in enumerate(hypothesis.accepted)
        if one.candidate.name == finding.effect
        and set(one.candidate.joints) <= set(finding.joints)
        and getattr(one.effect, "recording", "") == finding.recording
    ]
