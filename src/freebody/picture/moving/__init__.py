"""What an animation shows at each moment: poses, forces, contacts."""
