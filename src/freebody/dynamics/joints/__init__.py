"""What a joint lets free, and what it carries."""
