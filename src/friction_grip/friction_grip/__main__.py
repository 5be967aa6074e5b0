"""python3 -m friction_grip: the node."""

from friction_grip.ros.node import main

raise SystemExit(main())
