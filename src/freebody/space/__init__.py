"""Space: rotations, poses, motion and force vectors, mass properties and their theorems."""
