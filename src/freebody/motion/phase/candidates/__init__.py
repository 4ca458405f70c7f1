"""Kernels of all candidate contacts of a machine, whatever their modes."""
