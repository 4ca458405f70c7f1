"""Large trees: one compiled loop over the links in place of straight-line code.

Bottom up: link_step and link_places (one link), link_text (templates), tree_parts (straight code and places),
link_loop (the loops), tree_loop (the kernels).
"""
