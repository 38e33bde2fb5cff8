"""``python -m visualspeech``: the console command without its installed script."""

import sys

from visualspeech.cli import main

sys.exit(main())
