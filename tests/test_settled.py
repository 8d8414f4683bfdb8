"""What recordings of a session settle of its questions."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from physident.diagnosis.next_session.saved_session import SavedExpectation
from physident.diagnosis.next_session.settled import answers


@pytest.mark.parametrize(("grade", "settled"), [("cause", True), ("contribution", False)])
def test_a_rival_stands_for_what_is_not_found_any_more_only_as_a_cause(grade: str, settled: bool) -> None:
    """A little of what neither is may be fitted by either."""
    asked = SavedExpectation(
        kind="rival", question="?", effect="rotor_inertia", joints=(1,), power=0.5, detail="", rival="payload", rival_joints=(),
        parameter=0, size=1.0, smallest=0.5,
    )  # fmt: skip
    payload: Any = SimpleNamespace(effect="payload", joints=(), grade=grade, rivals=())
    found, none = SimpleNamespace(findings=(payload,), unseen=()), None
    (said,) = answers([asked], *(cast(Any, one) for one in (found, none, none, none)))
    assert said.settled == settled
    assert ("it is payload" in said.text) == settled
