"""python3 -m friction_state: the node."""

from friction_state.ros.node import main

raise SystemExit(main())
