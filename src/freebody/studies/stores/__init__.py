"""Files that keep the results of a study."""
