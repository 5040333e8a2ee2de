"""`python -m chrmc`."""

from chrmc.cli.main import main

if __name__ == "__main__":
    main()
