"""What a finding claims, joint by joint: findings join one effect over several joints, each of which is right or wrong."""

from __future__ import annotations

from typing import Any

Key = tuple[str, tuple[int, ...]]
WHOLE = frozenset({"coupled_friction", "payload", "gravity_tilt", "time_delay", "contact"})  # joints belong together


def claims(finding: Any) -> list[set[Key]]:
    """For each joint that a finding names, the causes that it may be: the effect there, and its rivals.

    A rival on a joint that the finding names stands beside that joint alone, any other beside all.
    """
    mine = _keys(finding.effect, finding.joints)
    named = {key[1] for key in mine}
    result = []
    for key in mine:
        own = {key}
        for rival in finding.rivals:
            theirs = _keys(rival.effect, rival.joints)
            own |= {other for other in theirs if other[1] == key[1] or other[1] not in named}
        result.append(own)
    return result


def _keys(effect: str, joints: Any) -> list[Key]:
    if effect in WHOLE or len(joints) < 2:
        return [(effect, tuple(joints))]
    return [(effect, (joint,)) for joint in joints]
