"""Paper: sheet, lines, labels, and the writers of SVG and TikZ."""
