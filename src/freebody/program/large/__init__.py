"""Large trees: one compiled loop over the links in place of straight-line code."""
