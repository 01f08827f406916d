"""The reference page of the command line, written from the commands themselves."""

from pathlib import Path

TITLE = "# The command line\n\nThis page is written from the commands by `rallygap docs`.\n\n"


def command_page(root: Path) -> str:
    """Return the commands of ``rallygap`` with their arguments and options as Markdown."""
    # Typer has no public function for what `typer ... utils docs` prints.
    from typer import Context
    from typer.cli import get_docs_for_click
    from typer.main import get_command

    from pipeline.cli import app

    command = get_command(app)
    text = get_docs_for_click(obj=command, ctx=Context(command), name="rallygap")
    return TITLE + text.replace("# `rallygap`\n", "", 1)
