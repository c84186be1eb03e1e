"""What a run will cost and how sure its means will be, told before it starts."""
