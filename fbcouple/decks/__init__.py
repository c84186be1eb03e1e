"""From a case to the solvers' input: what the scene needs, the numbers for it, the rendered decks."""
