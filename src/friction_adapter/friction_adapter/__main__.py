"""python -m friction_adapter: the node."""

from friction_adapter.node import main

raise SystemExit(main())
