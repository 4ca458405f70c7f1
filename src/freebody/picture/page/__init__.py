"""Offline HTML page: report, animation, live view."""
