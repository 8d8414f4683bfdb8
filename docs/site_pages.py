"""Pages of the site that are made at its build: the API, the command line, and the project's texts outside of docs/.

MkDocs calls the functions whose names start with ``on_`` (hooks of mkdocs.yml).
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import Any

import typer.main

import physident as pid
from physident.cli import app
from physident.cli.app import COMMANDS

ROOT = Path(__file__).resolve().parents[1]
SECTIONS = {"Tutorials": "tutorials", "How-to": "how-to", "Explanation": "explanation", "Reference": "reference"}
OUTSIDE = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
HEADINGS = {  # of the API, by the folder of a public name, in the order of a user's work
    "robots": "Robots",
    "recordings": "Recordings",
    "setup_checks": "Checks of the set-up",
    "dynamics": "Models",
    "effects": "Effects",
    "identifiability": "What recordings can show",
    "estimation": "Identification",
    "validation": "Validation",
    "diagnosis": "Diagnosis",
    "fleet": "Fleets",
    "excitation": "Motions to record",
    "simulation": "Simulation",
    "export": "Export",
    "graphics": "Sessions",
    "report": "Reports",
    "errors": "Errors",
}
LINK = re.compile(r"(!?)\[([^\]]+)\]\(([^)\s#:]+)(#[^)\s]*)?\)")
CODE = re.compile(r"(^```.*?^```$)", flags=re.S | re.M)
WIDTH = 110  # characters of a page of help


def api_page() -> str:
    """The reference of every public name, by docstring, in the order of a user's work."""
    folders: dict[str, list[str]] = {}
    for name, module in pid._PUBLIC.items():
        folders.setdefault(module.split(".")[0], []).append(f"physident.{module}.{name}")
    order = sorted(folders, key=lambda folder: list(HEADINGS).index(folder) if folder in HEADINGS else len(HEADINGS))
    lines = [
        "# Python",
        "",
        "All names below are attributes of the package: `import physident as pid`, then `pid.identify(...)`.",
    ]
    for folder in order:
        lines += ["", f"## {HEADINGS.get(folder, folder.replace('_', ' ').capitalize())}", ""]
        lines += [f"::: {path}\n" for path in folders[folder]]
    return "\n".join(lines)


def command_line_page() -> str:
    """The help of every command, as the parser prints it."""
    group: Any = typer.main.get_command(app)
    lines = [
        "# Command line",
        "",
        "Each page of help below is what `physident COMMAND --help` prints. Exit code 0 is success, 2 is unusable input, 3 is a"
        " problem that was not solved, 4 is a cause that `diagnose --fail-on cause` found, and 130 is Ctrl-C.",
    ]
    for heading, names in COMMANDS.items():
        lines += ["", f"## {heading.capitalize()}"]
        for name in names:
            command = group.get_command(None, name)
            context = type(command).context_class(command, info_name=f"physident {name}", max_content_width=WIDTH)
            context.terminal_width = WIDTH
            lines += ["", f"### physident {name}", "", "```text", command.get_help(context), "```"]
    return "\n".join(lines) + "\n"


MADE = {"reference/api.md": api_page, "reference/command-line.md": command_line_page}


def on_config(config: Any) -> Any:
    """Append to each section of the navigation the pages of its folder that it does not list yet."""
    for entry in config.nav:
        ((title, pages),) = entry.items()
        if folder := SECTIONS.get(title):
            found = [f"{folder}/{path.name}" for path in sorted((ROOT / "docs" / folder).glob("*.md"))]
            pages += [page for page in found if page not in pages]
        if title == "Project":
            pages += [path for path in _studies() if path.endswith(".md") and path not in pages]
    return config


def on_files(files: Any, config: Any) -> Any:
    """Add the pages that are made from code, and those that lie outside of docs/."""
    from mkdocs.structure.files import File

    for uri, make in MADE.items():
        files.append(File.generated(config, uri, content=make()))
    sources = OUTSIDE | {path: path for path in _studies()}
    for path, uri in sources.items():
        files.append(File.generated(config, uri, abs_src_path=str(ROOT / path)))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Links between the repository's files, as links between the site's pages."""
    return linked(markdown, page.file.src_uri)


def linked(markdown: str, uri: str) -> str:
    """The text of a page with its links turned to the site's pages; a link to a file without a page becomes its text."""
    inside = {site: path for path, site in OUTSIDE.items()}
    here = inside.get(uri) or (uri if uri.startswith("studies/") else f"docs/{uri}")

    def turned(match: re.Match[str]) -> str:
        mark, text, target, anchor = match.groups()
        path = posixpath.normpath(posixpath.join(posixpath.dirname(here), target))
        site = OUTSIDE.get(path, path.removeprefix("docs/"))
        if path.startswith("studies") and (ROOT / path).is_dir():
            site = f"{path}/README.md"
        elif not path.startswith("docs/") and path not in OUTSIDE and path not in _studies():
            return text
        return f"{mark}[{text}]({posixpath.relpath(site, posixpath.dirname(uri) or '.')}{anchor or ''})"

    parts = CODE.split(markdown)
    return "".join(part if part.startswith("```") else LINK.sub(turned, part) for part in parts)


def _studies() -> list[str]:
    """The pages and pictures of the studies, by their path in the repository."""
    found = [path for path in (ROOT / "studies").rglob("*") if path.suffix in (".md", ".png")]
    return sorted(path.relative_to(ROOT).as_posix() for path in found)
