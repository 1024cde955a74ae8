"""The pages of the diagnostics, one for each stage, from the explanations of their codes."""

from __future__ import annotations

from collections.abc import Iterator

from planarc.catalog.explanations import STAGES, Code, explain
from planarc_docs.written import fence, table


def code_pages() -> Iterator[tuple[str, str]]:
    """Names and texts of the pages."""
    for stage, title in STAGES.items():
        codes = [code for code in Code if code.name.startswith(stage)]
        head = f"# {stage}: {title}\n"
        listed = table(("code", "what it means"), (_row(code) for code in codes))
        yield stage, "\n".join((head, listed, *map(_section, codes)))


def _row(code: Code) -> tuple[str, str]:
    return f"[{code.name}](#{code.name.lower()})", code.value


def _section(code: Code) -> str:
    """A code with its cause, its example and its cure."""
    found = explain(code)
    example = [fence(kind, text) for kind, text in found.example]
    cure = f"**Cure.** {found.cure}\n"
    causes = [f"{paragraph}\n" for paragraph in found.cause]
    title = f"({code.name.lower()})=\n## {code.name}: {code.value}\n"
    return "\n".join((title, *causes, *example, cure))
