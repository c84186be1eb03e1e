"""The case file: what can be set (schema), how it is read (load), what must hold (checks), what follows (derived)."""
