"""The content by which two studies are the same."""
