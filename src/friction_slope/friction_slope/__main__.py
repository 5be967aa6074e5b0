"""python -m friction_slope: the node."""

from friction_slope.node import main

raise SystemExit(main())
