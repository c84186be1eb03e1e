"""Every option of a case, once: type, unit, range, default."""
