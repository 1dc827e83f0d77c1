#!/bin/sh
# State of job $1 in the words that Snakemake knows. A job that Slurm has forgotten has ended, how
# is not known: then its files decide, and Snakemake looks for those after success. Where Slurm does
# not answer, the next look will tell.
if ! state=$(squeue --noheader --states=all --format=%T --job "$1" 2>&1); then
    case "$state" in
        *"Invalid job id"*) state="" ;;
        *) state=UNKNOWN ;;
    esac
fi
case "$state" in
    COMPLETED | "") echo success ;;
    BOOT_FAIL | CANCELLED | DEADLINE | FAILED | NODE_FAIL | OUT_OF_MEMORY | PREEMPTED | TIMEOUT)
        echo failed
        ;;
    *) echo running ;;
esac
