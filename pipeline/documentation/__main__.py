"""Write the tables and the generated pages of the documentation: ``make docs`` calls this."""

from collections.abc import Callable
from pathlib import Path

from rallygap.pipeline.documentation.code_pages import catalogue_page, command_page
from rallygap.pipeline.documentation.tables import pages, with_tables
from rallygap.pipeline.io.artifacts import write_text
from rallygap.pipeline.runtime.paths import repository_root

PAGES: dict[str, Callable[[Path], str]] = {  # generated whole
    "docs/command-line.md": command_page,
    "docs/effects.md": catalogue_page,
}


def written_pages(root: Path) -> dict[Path, str]:
    """Return the text of every page of a repository, with what is generated in it.

    Raises:
        InputError: a block of a page is broken, or a report is.
    """
    whole = {root / name: write(root).rstrip() + "\n" for name, write in PAGES.items()}
    return whole | {page: with_tables(page, root) for page in pages(root) if page not in whole}


if __name__ == "__main__":
    repository = repository_root()
    for page, text in written_pages(repository).items():
        write_text(page, text)
