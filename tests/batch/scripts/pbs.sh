#!/bin/bash
#PBS -N bed
#PBS -l select=2:ncpus=4:mpiprocs=4:mem=3000mb
#PBS -l place=scatter
#PBS -l walltime=12:00:00
#PBS -j oe
#PBS -o /data/bed/batch/
#PBS -q long
#PBS -A beds
#PBS -M me@example.org
#PBS -m ae
#PBS -l filesystems=home

# Without one of these the run would meet another solver, or none.
stop() { echo "fbcouple batch: '$1' failed with exit code $2; the run is not started" >&2; exit 3; }
module load openmpi/4.1 || stop 'module load openmpi/4.1' $?
eval 'source /opt/openfoam2512/etc/bashrc' || stop 'source /opt/openfoam2512/etc/bashrc' $?
set -u

# Neither code nor programs come from the folder that the job starts in: empty and relative entries mean that folder.
for name in PATH LD_LIBRARY_PATH PYTHONPATH; do
    given=${!name-} kept=
    if [ "$name" = LD_LIBRARY_PATH ]; then given=${given//;/:}; fi
    while IFS= read -r -d : entry; do
        case "$entry" in /*) kept="$kept:$entry" ;; esac
    done <<< "$given:"
    export "$name=${kept#:}"
done
export PATH="${PATH:-/usr/local/bin:/usr/bin:/bin}" PYTHONSAFEPATH=1
export FBCOUPLE_LAUNCHER=srun FBCOUPLE_BIND=core

runs=(
    /data/bed
)
run="${runs[0]}"
state="$run/batch/state"
if [ ! -f "$run/case.toml" ]; then
    echo "fbcouple batch: $run is no run folder (no case.toml); if it was moved, write the job anew by: fbcouple batch" >&2
    exit 1
fi
mkdir -p "$run/batch"

# What the job before left: nothing (this is the first), "running" (it was killed, or is still at it), 75 (stopped with a
# checkpoint); any other exit code is final, and a job that was handed in to go on has nothing to do.
look() {
    left=$(cat "$state" 2>/dev/null)
    case "$left" in
        "" | running | 75 | *[!0-9]*) ;;
        0) echo "fbcouple batch: $run is done, a job before brought it to its end ($state)"; exit 0 ;;
        *)
            echo "fbcouple batch: $run: a job before ended with exit code $left ($state), the run is not started" >&2
            echo "fbcouple batch: to start it all the same: "/data/bed/batch/submit-pbs.sh >&2
            exit "$left"
            ;;
    esac
}

# Signals: USR1 is the notice before the limit, TERM and INT come from whoever ends the job.
job= caught= noticed= ended=
hand_on() { caught=1; [ -z "$job" ] || kill "-$1" "$job" 2>/dev/null; }
trap 'noticed=1; hand_on USR1' USR1
trap 'ended=1; hand_on TERM' TERM INT
follow() {
    job=$!
    if [ -n "$caught" ]; then kill -USR1 "$job"; fi # it came before there was anybody to hand it on to
    # A trapped signal ends `wait` early, with a code above 128; the run's own code is still to come.
    while :; do
        caught=
        wait "$job"
        code=$?
        if [ "$code" -le 128 ] || [ -z "$caught" ]; then break; fi
    done
}
start() {
    look
    echo running > "$state"
    /opt/venv/bin/python -m fbcouple.cli.main run "$run" -n 8 --wall-limit 42600 --resume &
    follow
}
start
if [ "$code" = 69 ] && [ "$left" = running ]; then
    echo "fbcouple batch: $run: once more in 150 s: what was killed with its node counts as under way for a while" >&2
    sleep 150 &
    follow
    if [ "$code" -le 128 ]; then start; fi
fi
case "$code" in
    130 | 138 | 143) code=75 ;; # ended by a signal before it could listen: no step was taken
    3) if [ -n "$ended" ] && [ -z "$noticed" ]; then code=75; fi ;; # its ranks had the signal, too, before they listened
esac
case "$code" in
    69) ;; # another job has the run, and the state is that one's
    137) ;; # killed: a job after this one goes on
    *) echo "$code" > "$state" ;;
esac
# Cancelled or preempted, not at its limit: such a job does not put itself back into the queue.
if [ "$code" = 75 ] && [ -n "$ended" ] && [ -z "$noticed" ]; then code=143; fi
exit "$code"
