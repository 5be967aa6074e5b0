"""python3 -m friction_slope: the node."""

from friction_slope.ros.node import main

raise SystemExit(main())
