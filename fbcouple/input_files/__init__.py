"""Files that users write beside a case: tables of numbers and measured lines."""
