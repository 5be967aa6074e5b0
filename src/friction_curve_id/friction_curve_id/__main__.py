"""python3 -m friction_curve_id: the node."""

from friction_curve_id.ros.node import main

raise SystemExit(main())
