"""A diagnosis as a page for the person who decides."""

from physident.report.page import report_html, write_report

__all__ = ["report_html", "write_report"]
