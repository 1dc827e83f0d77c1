#!/bin/sh
# State of job $1 in the words that Snakemake knows. A job that Slurm has forgotten has ended, how
# is not known: then its files decide, and Snakemake looks for those after success.
state=$(squeue --noheader --states=all --format=%T --job "$1" 2>/dev/null)
case "$state" in
    COMPLETED | "") echo success ;;
    BOOT_FAIL | CANCELLED | DEADLINE | FAILED | NODE_FAIL | OUT_OF_MEMORY | PREEMPTED | TIMEOUT)
        echo failed
        ;;
    *) echo running ;;
esac
