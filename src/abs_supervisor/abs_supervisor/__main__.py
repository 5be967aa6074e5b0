"""python3 -m abs_supervisor: the node."""

from abs_supervisor.ros.node import main

raise SystemExit(main())
