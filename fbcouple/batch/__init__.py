"""Many runs: the folders of a set, how far each has come, all side by side, and job scripts of batch systems."""
