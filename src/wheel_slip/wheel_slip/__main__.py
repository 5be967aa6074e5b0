"""python -m wheel_slip: the node."""

from wheel_slip.node import main

raise SystemExit(main())
