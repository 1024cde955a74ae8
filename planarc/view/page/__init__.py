"""One self-contained HTML page of a run: the moving mechanism beside curves."""

from planarc.view.page.report import write_report

__all__ = ["write_report"]
