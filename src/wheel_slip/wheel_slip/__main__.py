"""python3 -m wheel_slip: the node."""

from wheel_slip.ros.node import main

raise SystemExit(main())
