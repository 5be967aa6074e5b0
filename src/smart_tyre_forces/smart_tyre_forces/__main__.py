"""python3 -m smart_tyre_forces: the node."""

from smart_tyre_forces.ros.node import main

raise SystemExit(main())
