"""What accuracy costs, and what blows up: `fbcouple study`."""
