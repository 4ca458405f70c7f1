"""Reducers: statistics of many runs that merge exactly, so that no order of the work changes a bit of them."""
