"""What lies in a run folder, for the launcher and the ranks alike."""
