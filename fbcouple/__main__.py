"""`python -m fbcouple`: the same as the `fbcouple` command."""

from fbcouple.cli.main import main

if __name__ == "__main__":
    main()
