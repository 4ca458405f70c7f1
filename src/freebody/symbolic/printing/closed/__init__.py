"""Closed-form answers as a book prints them: one root, one fraction, common factors in front."""
