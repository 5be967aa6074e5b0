"""python3 -m friction_adapter: the node."""

from friction_adapter.ros.node import main

raise SystemExit(main())
