"""From a recorded computation to LLVM IR."""
