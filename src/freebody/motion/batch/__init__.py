"""Many motions of one machine: lanes, threads, processes, results on disk."""
