"""The form of the command line: options that take several files, help, version, suggestions."""

from __future__ import annotations

import subprocess
import sys

import pytest

from physident.cli import run
from physident.cli.app import COMMANDS
from physident.cli.verb import repeated

SEVERAL = {"--holdout", "--on"}
VERBS = [verb for verbs in COMMANDS.values() for verb in verbs]


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("a --holdout b c", "a --holdout b --holdout c"),
        ("a --holdout b c --json d", "a --holdout b --holdout c --json d"),
        ("--holdout=b c --on d e", "--holdout b --holdout c --on d --on e"),
        ("a --holdout b --holdout c", "a --holdout b --holdout c"),
        ("--json x a b", "--json x a b"),
        ("--holdout b --seed 3 a", "--holdout b --seed 3 a"),
        ("a --holdout", "a --holdout"),
    ],
)
def test_an_option_of_several_files_takes_all_words_up_to_the_next_option(typed: str, meant: str) -> None:
    assert repeated(typed.split(), SEVERAL) == meant.split()


def test_a_pattern_after_holdout_never_ends_among_the_diagnosed_recordings(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    seen: list[list[str]] = []

    def read(paths: list[str], *_: object, **__: object) -> list:
        seen.append(list(paths))
        return []

    monkeypatch.setattr("physident.cli.diagnosis.diagnose.read_recordings", read)
    assert run(["diagnose", "--robot", "ur5", "a.csv", "--holdout", "b.csv", "c.csv", "d.csv"]) == 2
    assert seen == [["a.csv"], ["b.csv", "c.csv", "d.csv"]]
    capfd.readouterr()
    assert run(["diagnose", "--robot", "ur5", "--holdout", "b.csv", "a.csv"]) == 2  # no recording remains to diagnose
    assert "RECORDING" in capfd.readouterr().err


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("option", ["-h", "--help"])
def test_every_verb_explains_itself_in_words(verb: str, option: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert run([verb, option]) == 0
    shown = capfd.readouterr().out
    assert "--force" in shown
    assert "<" not in shown.replace("-> ", "")
    assert "{" not in shown


@pytest.mark.parametrize("verb", sorted(set(VERBS) - {"demo", "export", "report", "view"}))
def test_every_verb_that_computes_has_json(verb: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert run([verb, "--help"]) == 0
    assert "--json FILE" in capfd.readouterr().out


def test_version_and_module() -> None:
    done = subprocess.run([sys.executable, "-m", "physident", "--version"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "physident 0.1.0\n", "")


def test_completion_can_be_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    # the shell is named, because none may be there to be found
    monkeypatch.setenv("_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION", "1")
    command = [sys.executable, "-m", "physident", "--show-completion", "bash"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "physident" in done.stdout
    assert "complete" in done.stdout


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        (["diagnose", "--holdot", "x"], "did you mean --holdout; see physident diagnose --help"),
        (["identify", "a.csv", "--roboter", "ur5"], "did you mean --robot; see physident identify --help"),
        (["dignose"], "'diagnose'"),
        (["design", "--rate", "fast"], "see physident design --help"),
        (["base-parameters", "--robot", "ur5", "--effects", "rigid_bodi"], "did you mean 'rigid_body'"),
        (["base-parameters", "--robot", "ur5", "--effects", "friction"], "did you mean"),
        (["identify", "a.csv", "--robot", "ur55", "--out", "-"], "did you mean 'ur5'"),
        (["design", "--robot", "ur5", "--limits", "joints", "--out", "-"], "did you mean 'joint'"),
    ],
)
def test_the_nearest_name_is_suggested(typed: list[str], said: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(typed) == 2
    assert said in capfd.readouterr().err


@pytest.mark.parametrize("frequency", ["1e200", "1e-200", "0", "nan", "inf", "-1"])
def test_a_base_frequency_that_no_arm_can_follow(frequency: str, capfd: pytest.CaptureFixture[str]) -> None:
    command = ["design", "--robot", "ur5", "--limits", "joint", "--out", "-", f"--base-frequency={frequency}"]
    assert run(command) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert "base_frequency is" in err
    assert err.count("\n") == 1
