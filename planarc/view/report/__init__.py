"""One self-contained HTML page of a run: the moving mechanism beside curves."""

from planarc.view.report.page import write_report

__all__ = ["write_report"]
