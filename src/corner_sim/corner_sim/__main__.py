"""`python -m corner_sim` starts the node."""

from corner_sim.node import main

if __name__ == "__main__":
    main()
