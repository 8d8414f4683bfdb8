"""The site's pages: every page is in the navigation, every link leads somewhere, and the made pages are complete."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import pytest

import physident as pid
from physident.cli.app import COMMANDS
from tests.conftest import ROOT
from tests.test_house import script

DOCS = ROOT / "docs"
PAGES = sorted([*DOCS.rglob("*.md"), *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"))])
CODE = re.compile(r"^```.*?^```$|`[^`\n]+`", flags=re.S | re.M)
LINK = re.compile(r"\]\(([^)\s]+)\)")
MADE = ("reference/api.md", "reference/command-line.md")


def anchors(page: Path) -> set[str]:
    """The names of a page's headings, as GitHub and MkDocs make them."""
    heads = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), flags=re.M)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_to_files_and_headings(page: Path) -> None:
    for link in LINK.findall(CODE.sub("", page.read_text(encoding="utf-8"))):
        if "://" in link:
            continue
        name, _, anchor = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        assert target.exists(), f"{link} leads nowhere"
        assert not anchor or anchor in anchors(target), f"{link}: no such heading"


def test_the_navigation_names_pages_that_exist() -> None:
    module = script("site_pages")
    known = {*module.MADE, *module.OUTSIDE.values(), *module._studies()}
    named = re.findall(r"^\s+- (?:\w+: )?(\S+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), flags=re.M)
    assert len(named) == len(set(named)) > 20
    assert all(name in known or (DOCS / name).is_file() for name in named)


def test_links_between_pages_of_the_site() -> None:
    """A link of the repository becomes the link of the site; code, and files without a page, are left as text."""
    linked = script("site_pages").linked
    assert linked("[a](../../CONTRIBUTING.md#style)", "reference/effects.md") == "[a](../contributing.md#style)"
    assert linked("[b](../../studies/replay/README.md)", "how-to/mujoco.md") == "[b](../studies/replay/README.md)"
    assert linked("[c](docs/how-to/mujoco.md)", "index.md") == "[c](how-to/mujoco.md)"
    assert linked("[d](../../physident/robots/ur5.toml)", "reference/robots.md") == "d"
    assert linked("[e](https://rerun.io)", "index.md") == "[e](https://rerun.io)"
    assert linked("```python\nf[g](q.md)\n```", "index.md") == "```python\nf[g](q.md)\n```"


def test_the_reference_has_every_command_and_every_public_name() -> None:
    module = script("site_pages")
    commands, api = module.command_line_page(), module.api_page()
    for name in (name for names in COMMANDS.values() for name in names):
        assert f"### physident {name}\n" in commands
        assert f"Usage: physident {name} " in commands
    missing = [name for name in pid._PUBLIC if not re.search(rf"^::: physident\.[\w.]+\.{name}$", api, flags=re.M)]
    assert not missing


def test_every_page_says_what_it_is() -> None:
    """A page starts with one title, and a title of another level follows none that is missing."""
    for page in DOCS.rglob("*.md"):
        text = CODE.sub("", page.read_text(encoding="utf-8"))
        levels = [len(mark) for mark in re.findall(r"^(#+) ", text, flags=re.M)]
        assert levels[0] == 1, page
        assert levels.count(1) == 1, page
        assert all(b <= a + 1 for a, b in pairwise(levels)), page
