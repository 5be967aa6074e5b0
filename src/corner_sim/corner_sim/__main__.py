"""`python3 -m corner_sim` starts the node."""

import sys

from corner_sim.ros.node import main

if __name__ == "__main__":
    sys.exit(main())
