"""`python -m nsrm_harness.cli`."""

from nsrm_harness.cli.main import main

main()
