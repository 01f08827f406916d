"""The results page as a PDF (``make docs``), set by Typst; a commit gives the same bytes again."""

import json
from pathlib import Path
from typing import Any

from rallygap.pipeline.io.artifacts import replacing
from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.print.typst_markup import typst_markup
from rallygap.pipeline.runtime.git import git_commit
from rallygap.pipeline.runtime.paths import repository_root

PAGE = Path("docs") / "results.md"
PDF = Path("docs") / "_build" / "results.pdf"
TEMPLATE = Path(__file__).with_name("results.typ")


def results_pdf(root: Path) -> Path:
    """Write and return the PDF of the results page.

    Args:
        root: of the repository.
    """
    import typst

    content = typst_markup((root / PAGE).read_text(encoding="utf-8"))
    inputs = {"about": json.dumps(_about(root)), "content": content}
    template = TEMPLATE.read_bytes()
    document = typst.Compiler(template, root, ignore_system_fonts=True, sys_inputs=inputs)
    with replacing(root / PDF) as temporary:
        document.compile(output=temporary, format="pdf")
    return root / PDF


def _about(root: Path) -> dict[str, Any]:
    cited = read_yaml(root / "CITATION.cff")
    about = {key: str(cited[key]) for key in ("title", "abstract", "version")}
    return about | {"commit": (git_commit(root) or "unknown")[:7]}


if __name__ == "__main__":
    results_pdf(repository_root())
