"""What follows from a case: particle types, contacts, region and start."""
