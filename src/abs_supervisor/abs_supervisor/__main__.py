"""python -m abs_supervisor: the node."""

from abs_supervisor.node import main

raise SystemExit(main())
