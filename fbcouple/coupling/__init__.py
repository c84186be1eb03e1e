"""How particles and gas see each other."""
