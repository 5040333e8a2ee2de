"""What holds for all tests."""

import signal

# A shell's background jobs and nohup ignore Ctrl-C, and programs started from there would too:
# tests that interrupt them must not depend on how they were started themselves.
signal.signal(signal.SIGINT, signal.default_int_handler)
