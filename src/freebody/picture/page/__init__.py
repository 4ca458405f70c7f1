"""Offline HTML pages: report, animation, live view."""
