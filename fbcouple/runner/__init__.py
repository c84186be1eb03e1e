"""Many runs at once: the run folders of a set, how far each has come, and all of them run side by side."""
