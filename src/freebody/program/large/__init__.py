"""Large trees: one compiled loop over the links in place of straight-line code.

Bottom up: link_step and link_places (one link), tree_parts (straight code and places), tree_walk (the loops, compiled
once for all trees), tree_code (a tree's entry to them), tree_loop (the kernels).
"""
