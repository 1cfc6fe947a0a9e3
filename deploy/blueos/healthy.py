"""For Docker's HEALTHCHECK: ends with 0 where the learner answers its page, with 1 else."""

import json
import os
import sys
from urllib.request import urlopen

with urlopen(f"http://127.0.0.1:{os.environ.get('PAGE_PORT', '9110')}/state.json", timeout=8.0) as answer:
    sys.exit(json.load(answer)["away"])  # a text goes to standard error, with status 1
