"""Tools shared by the gallery: entries, cases, answers, pictures."""
