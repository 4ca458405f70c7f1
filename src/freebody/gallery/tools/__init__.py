"""What the entries of the gallery share: entries, cases, answers, pictures."""
