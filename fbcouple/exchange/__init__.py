"""Between gas cells and particles: who needs which cells, weights, filter, drag laws, momentum."""
